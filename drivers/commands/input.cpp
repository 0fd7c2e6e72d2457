#include "commands/input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "checks/read_case.hpp"
#include "ductile/fluid/mpi.hpp"
#include "output/say.hpp"
#include "run/exit_code.hpp"
#include "run/root.hpp"
#include "scenario/errors.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {

std::vector<std::vector<std::string>> advise(const std::vector<std::pair<std::string, Case>>& cases,
                                             double patience) {
  std::vector<std::vector<std::string>> of_cases;
  std::vector<std::pair<std::string, std::vector<std::string>>> lines;
  for (const auto& [name, given] : cases) {
    std::vector<std::string> said;
    for (const std::string& note : notes(given)) said.push_back("note: " + note);
    of_cases.push_back(warnings(given, patience));
    for (const std::string& warning : of_cases.back()) said.push_back("warning: " + warning);
    for (const std::string& line : said) {
      auto known = std::find_if(lines.begin(), lines.end(),
                                [&line](const auto& entry) { return entry.first == line; });
      if (known == lines.end()) known = lines.insert(lines.end(), {line, {}});
      known->second.push_back(name);
    }
  }
  for (const auto& [line, names] : lines) {
    const std::string about =
        names.size() == cases.size() ? "" : fmt::format(" (of {})", some_of(names));
    say(stderr, "{}{}\n", line, about);
  }
  return of_cases;
}

int with_input(MPI_Comm comm, const std::function<void()>& work) {
  return on_root(comm, exit_failure, [&]() -> int {
    try {
      work();
      return exit_success;
    } catch (const InputError& error) {
      say(stderr, "{}\n", error.what());
      return exit_bad_input;
    }
  });
}

Case shared_case(std::string& scenario, MPI_Comm comm) {
  broadcast(scenario, comm);
  return parse_case(scenario, "scenario.toml");
}

void require_memory(const Case& given, const Ranks& ranks) {
  if (const std::string lack = memory_lacks(given, ranks); !lack.empty())
    throw InputError("ductile: " + lack);
}

bool enough_planes(const Case& given, MPI_Comm comm) {
  int ranks = 1;
  fluid::mpi_check(MPI_Comm_size(comm, &ranks), "MPI_Comm_size");
  const int planes = given.plan.fluid.nodes[2];
  if (ranks <= planes) return true;
  if (rank_in(comm) == 0) {
    say(stderr, "ductile: {} ranks cannot share {} planes of nodes: use fewer ranks\n", ranks,
        planes);
  }
  return false;
}

}  // namespace ductile::drivers
