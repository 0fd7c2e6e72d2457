#include "output/process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>
#include <utility>

#include "output/file.hpp"

namespace ductile::drivers {

namespace {

std::vector<std::string>& kept_environment() {
  static std::vector<std::string> kept;
  return kept;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> list;
  list.reserve(texts.size() + 1);
  for (std::string& text : texts) list.push_back(text.data());
  list.push_back(nullptr);
  return list;
}

// Between fork and exec: nothing but system calls.
[[noreturn]] void become(char* const* arguments, char* const* environment, int said, int failure,
                         pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGUSR2);
  for (const int number : {SIGTERM, SIGINT, SIGUSR1, SIGUSR2, SIGPIPE, SIGXFSZ})
    std::signal(number, SIG_DFL);
  const int nothing = open("/dev/null", O_RDONLY);
  // It may have died before it was to be told.
  if (getppid() == parent && nothing >= 0 && dup2(nothing, STDIN_FILENO) >= 0 &&
      dup2(said, STDOUT_FILENO) >= 0 && dup2(said, STDERR_FILENO) >= 0)
    execvpe(arguments[0], arguments, environment);
  const int reason = errno;
  static_cast<void>(write(failure, &reason, sizeof(reason)) > 0);
  _exit(127);
}

}  // namespace

Process::Process(const std::vector<std::string>& arguments,
                 const std::vector<std::string>& environment, const std::filesystem::path& said) {
  std::vector<std::string> own_arguments = arguments;
  std::vector<std::string> own_environment = environment;
  const std::vector<char*> argv = pointers(own_arguments);
  const std::vector<char*> envp = pointers(own_environment);
  const int out = open(said.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (out < 0) fail_to_write(said, errno);
  // Closed by exec; else it tells why there was none.
  std::array<int, 2> failure{};
  if (pipe2(failure.data(), O_CLOEXEC) != 0) {
    close(out);
    throw OutputError(fmt::format("cannot start a process: {}", std::strerror(errno)));
  }
  const pid_t parent = getpid();
  child_ = fork();
  if (child_ == 0) become(argv.data(), envp.data(), out, failure[1], parent);
  int reason = child_ < 0 ? errno : 0;
  close(out);
  close(failure[1]);
  if (child_ > 0 && read(failure[0], &reason, sizeof(reason)) <= 0) reason = 0;
  close(failure[0]);
  if (reason == 0) return;
  if (child_ > 0) waitpid(child_, nullptr, 0);
  child_ = -1;
  throw OutputError(fmt::format("cannot start {}: {}", arguments[0], std::strerror(reason)));
}

Process::Process(Process&& other) noexcept
    : child_(std::exchange(other.child_, -1)), ending_(other.ending_) {}

Process& Process::operator=(Process&& other) noexcept {
  std::swap(child_, other.child_);
  std::swap(ending_, other.ending_);
  return *this;
}

Process::~Process() {
  if (child_ < 0 || ending_) return;
  while (waitpid(child_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

std::optional<Ending> Process::ended() {
  int status = 0;
  if (!ending_ && waitpid(child_, &status, WNOHANG) == child_) {
    ending_.emplace();
    if (WIFEXITED(status)) ending_->code = WEXITSTATUS(status);
    if (WIFSIGNALED(status)) ending_->signal = WTERMSIG(status);
  }
  return ending_;
}

void Process::signal(int number) const {
  if (child_ > 0 && !ending_) ::kill(child_, number);
}

void keep_environment() {
  for (char** entry = environ; *entry != nullptr; ++entry) kept_environment().emplace_back(*entry);
}

std::vector<std::string> environment_without_job() {
  if (kept_environment().empty()) keep_environment();
  std::vector<std::string> kept;
  for (const std::string& text : kept_environment()) {
    bool of_job = false;
    for (const std::string_view prefix :
         {"OMPI_COMM_", "OMPI_UNIVERSE", "OMPI_APP", "OMPI_NUM", "OMPI_FIRST", "OMPI_FILE",
          "OMPI_COMMAND", "OMPI_ARGV", "OMPI_MCA_ess", "OMPI_MCA_orte", "OMPI_MCA_pmix", "PMIX_",
          "PMI_", "ORTE_", "PRTE_"})
      of_job = of_job || text.starts_with(prefix);
    if (!of_job) kept.push_back(text);
  }
  return kept;
}

}  // namespace ductile::drivers
