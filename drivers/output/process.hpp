// A process of another program.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ductile::drivers {

/// How a process ended.
struct Ending {
  int code = 0;    ///< that it returned
  int signal = 0;  ///< that killed it, if one has
};

/// A child in a process group of its own, so that what the terminal sends does not reach it. It is
/// sent SIGUSR2 if this program dies. Not to be used while MPI is up.
class Process {
 public:
  /// `arguments[0]` is looked for on PATH; the environment is `environment`, entries NAME=VALUE;
  /// what it says goes into the file. Throws OutputError.
  Process(const std::vector<std::string>& arguments, const std::vector<std::string>& environment,
          const std::filesystem::path& said);
  Process(Process&& other) noexcept;
  Process& operator=(Process&& other) noexcept;
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  /// Waits for its end.
  ~Process();

  /// Its end, once it has come.
  [[nodiscard]] std::optional<Ending> ended();
  /// Sends it a signal: to the child alone, which is mpirun where there are ranks.
  void signal(int number) const;

 private:
  pid_t child_ = -1;
  std::optional<Ending> ending_;
};

/// For the very start of the program: MPI adds to the environment when it comes up.
void keep_environment();
/// The environment as it was kept (or is now, if it was not) without what ties a process to an MPI
/// job.
std::vector<std::string> environment_without_job();

}  // namespace ductile::drivers
