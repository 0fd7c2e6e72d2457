// What can go wrong with a user's input.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace ductile::drivers {

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
