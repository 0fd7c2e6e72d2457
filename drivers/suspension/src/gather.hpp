// What owners know, brought to rank 0.
#pragma once

#include <mpi.h>

#include <span>
#include <vector>

namespace ductile::suspension {

/// Numbers travel from the rank that has them to rank 0, in messages whose size only the owner
/// knows.
class Gather {
 public:
  /// `comm` must outlive it.
  explicit Gather(MPI_Comm comm);
  /// On rank 0 the owner's `values`; what this rank has given elsewhere. Collective over the owner
  /// and rank 0. Throws fluid::MpiFailure.
  [[nodiscard]] std::vector<double> from(int owner, std::span<const double> values) const;

 private:
  MPI_Comm comm_;
  int rank_ = 0;
};

}  // namespace ductile::suspension
