// Bodies that fail within a step.
#pragma once

#include <climits>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "ductile/coupling/coupler.hpp"
#include "ductile/fluid/mpi.hpp"

namespace ductile::coupling {

/// The failure of a step on this rank, kept until all ranks can learn of it. Of several that of the
/// lowest body id counts.
class Failures {
 public:
  /// `marker`: the one at fault, where it was one.
  void add(int body, BodyFailure::Cause cause, std::optional<std::size_t> marker,
           const std::string& reason);
  [[nodiscard]] bool any() const { return body_ != INT_MAX; }
  /// Whether a failure of `body` would not count any more.
  [[nodiscard]] bool precede(int body) const { return body_ <= body; }
  /// Throws BodyFailure on all ranks, with the failure of the lowest body id of all; there are none
  /// after that. Collective; at least one rank has a failure.
  [[noreturn]] void raise(const fluid::Communicator& comm, std::int64_t step);

 private:
  int body_ = INT_MAX;
  BodyFailure::Cause cause_ = BodyFailure::Cause::body;
  std::optional<std::size_t> marker_;
  std::string reason_;
};

}  // namespace ductile::coupling
