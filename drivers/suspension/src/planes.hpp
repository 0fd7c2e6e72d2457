// Numbers of nodes: the slabs of all ranks, put together on rank 0 and dealt out again.
#pragma once

#include <mpi.h>

#include <cstddef>
#include <span>
#include <vector>

#include "ductile/fluid/fluid.hpp"

namespace ductile::suspension {

/// One number a node, of the whole lattice: [(i ny + j) nz + k]. A slab has the same of its planes.
class Planes {
 public:
  /// Both must outlive it.
  Planes(const fluid::Fluid& fluid, MPI_Comm comm);

  [[nodiscard]] std::size_t own_size() const { return size_of(rank_); }
  [[nodiscard]] std::size_t whole_size() const { return columns_ * planes_; }
  /// All ranks' slabs as a whole on rank 0, nothing on the others. Collective.
  [[nodiscard]] std::vector<double> gathered(std::span<const double> own) const;
  /// own <- this rank's slab of rank 0's `whole`. Collective.
  void scatter(std::span<const double> whole, std::span<double> own) const;

 private:
  [[nodiscard]] std::size_t size_of(int rank) const;

  const fluid::Fluid& fluid_;
  MPI_Comm comm_;
  int rank_ = 0;
  int ranks_ = 1;
  std::size_t columns_;
  std::size_t planes_;
};

}  // namespace ductile::suspension
