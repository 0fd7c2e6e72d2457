// What can go wrong with a user's input, and the exit codes of the program.
#pragma once

#include <stdexcept>
#include <string>

namespace ductile::drivers {

/// Exit codes of the program, as `ductile --help` documents them.
enum ExitCode : int {
  exit_success = 0,
  exit_failure = 1,    ///< the run could not be done: a full disk, no memory, a solver's failure
  exit_bad_input = 2,  ///< wrong usage or a wrong scenario; nothing was written
  exit_blow_up = 3     ///< the fluid or a body became unstable
};

/// Wrong usage or a wrong scenario. what() is the one line for the user: where, what, the bound and
/// what to do.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A scenario whose values do not go together. Says which key is to blame ("body.lag.x"); whoever
/// knows the file makes an InputError of it, with line and column.
class ScenarioError : public std::runtime_error {
 public:
  ScenarioError(std::string key, const std::string& message)
      : std::runtime_error(message), key_(std::move(key)) {}
  [[nodiscard]] const std::string& key() const { return key_; }

 private:
  std::string key_;
};

}  // namespace ductile::drivers
