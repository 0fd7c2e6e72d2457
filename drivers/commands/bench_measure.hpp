// What `ductile bench` measures: how fast this machine is, and how near the program comes to what
// its memory allows.
#pragma once

#include <mpi.h>

#include <array>
#include <string>
#include <vector>

#include "checks/speed.hpp"
#include "output/profile.hpp"

namespace ductile::drivers {

struct BenchOptions {
  int nodes = 90;   ///< across the square channel, which is six times as long
  int repeats = 9;  ///< of each measurement
  bool json = false;
};

/// One thing timed, in turn with the ceiling and with what else it is compared with, so that all
/// meet the machine in the same state. The ceiling is the loads and stores of the fluid's step and
/// nothing else, on all ranks.
struct BenchRow {
  std::string name;
  int ranks = 1;
  std::vector<double> updates;   ///< nodes a second, of each repeat
  std::vector<double> fraction;  ///< of the ceiling, likewise
  std::string reference;         ///< what else it is compared with: "" if nothing
  std::vector<double> relative;  ///< speed over the reference's, likewise
};

/// Of the populations and of the collision.
struct BenchPrecision {
  fluid::Precision storage;
  fluid::Precision arithmetic;
};

/// One precision.
struct BenchTable {
  BenchPrecision precision{};
  std::vector<double> ceiling;  ///< updates a second on all ranks, of every repeat of every row
  std::vector<BenchRow> rows;
  RunProfile coupled;  ///< of the coupled step on all ranks
};

struct BenchResult {
  std::array<int, 3> nodes{};
  int ranks = 1;
  int cores = 1;
  std::string instruction_set;
  int triangles = 0;  ///< of each of the two capsules
  std::vector<BenchTable> tables;
  BodyCosts bodies;  ///< of rank 0, alone
};

/// Of 90 nodes and the usual repeats, about two minutes. Collective; the result is rank 0's.
/// Throws InputError, on every rank, if the fluids that are there at a time exceed the memory of
/// rank 0's machine, or if there are more ranks than planes of nodes.
BenchResult measure(const BenchOptions& options, MPI_Comm comm);

std::string table(const BenchResult& result);
std::string json(const BenchResult& result);

/// Whether the result may stand for the machine: of the default lattice, and of no more ranks than
/// cores.
bool is_representative(const BenchResult& result);
/// What `check` estimates durations from: the fluid on all ranks and on one, and bodies.
KnownSpeed speed_of(const BenchResult& result);

}  // namespace ductile::drivers
