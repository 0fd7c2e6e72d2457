// Surfaces that have come nearer to each other than the method resolves.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ductile/suspension/gaps.hpp"
#include "ductile/suspension/plan.hpp"

namespace ductile::drivers {

/// A gap that has been smaller than the kernel's reach.
struct Contact {
  suspension::Gap smallest;  ///< so far; after a crossing, the gap that crossed first
  double time = 0;           ///< of the smallest [W^2/nu]
  double since = 0;          ///< when it was first seen that small

  [[nodiscard]] bool crossed() const { return smallest.crossed; }
};

/// What there is to tell of the gaps of a run: each once, however often it opens and closes.
class Contacts {
 public:
  Contacts() = default;
  /// Goes on after those.
  explicit Contacts(std::vector<Contact> contacts) : contacts_(std::move(contacts)) {}

  /// Takes the gaps below suspension::kernel_reach at `time`. True if surfaces cross that did not
  /// before.
  bool update(double time, const std::vector<suspension::Gap>& gaps);
  /// In the order in which they were first seen.
  [[nodiscard]] const std::vector<Contact>& all() const { return contacts_; }

 private:
  std::vector<Contact> contacts_;
};

/// How messages call a body, a wall, and what is across a gap: `body "lag"`, "the wall at x = -1",
/// "its own periodic image".
std::string body_name(const suspension::Plan& plan, std::size_t body);
std::string wall_name(const suspension::Plan& plan, const suspension::Gap& gap);
std::string across_name(const suspension::Plan& plan, const suspension::Gap& gap);

/// Whether the two feel the film between them (suspension::has_films()): what the lattice does not
/// resolve there is then no lack.
bool has_film(const suspension::Plan& plan, const suspension::Gap& gap);

/// The contact in a sentence, in the paper's units.
std::string description(const suspension::Plan& plan, const Contact& contact);

}  // namespace ductile::drivers
