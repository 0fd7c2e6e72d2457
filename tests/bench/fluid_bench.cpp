// Speed of the fluid alone, in million lattice updates a second:
//     mpirun -n 2 fluid_bench [nodes across = 90] [double|single] [halfway|regularized]
// The channel is six times as long as wide. Prints the best of five runs, and all of them.
#include <mpi.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "ductile/fluid/fluid.hpp"

namespace {

void run(int nodes, bool single, bool on_nodes) {
  using namespace ductile::fluid;
  Options options;
  options.nodes = {nodes, nodes, 6 * nodes};
  const Boundary walls = on_nodes ? Boundary::regularized : Boundary::halfway;
  options.boundary = {walls, walls, Boundary::periodic};
  options.tau = 0.9;
  options.force = {0, 0, 1e-6};
  options.storage = single ? Storage::single_precision : Storage::double_precision;
  Fluid fluid(MPI_COMM_WORLD, options);
  const double count = 6.0 * nodes * nodes * nodes;
  const int steps = std::max(4, static_cast<int>(1e8 / count));
  std::array<double, 5> rates{};
  fluid.step();
  fluid.step();
  for (double& rate : rates) {
    MPI_Barrier(MPI_COMM_WORLD);
    const double start = MPI_Wtime();
    for (int n = 0; n < steps; ++n) fluid.step();
    MPI_Barrier(MPI_COMM_WORLD);
    rate = count * steps / (MPI_Wtime() - start) / 1e6;
  }
  int rank = 0;
  int ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  if (rank != 0) return;
  std::printf("%d x %d x %d, %s, %s walls, %d ranks: %.1f million updates a second (", nodes, nodes,
              6 * nodes, single ? "single" : "double", on_nodes ? "regularized" : "half-way", ranks,
              *std::max_element(rates.begin(), rates.end()));
  for (const double rate : rates) std::printf(" %.1f", rate);
  std::printf(" )\n");
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  const auto given = [&](const char* word) {
    return std::any_of(argv + 1, argv + argc, [&](const char* a) { return !std::strcmp(a, word); });
  };
  const int nodes = argc > 1 ? std::atoi(argv[1]) : 90;  // NOLINT(cert-err34-c): 0 is rejected
  if (nodes >= 4) run(nodes, given("single"), given("regularized"));
  MPI_Finalize();
  return nodes >= 4 ? 0 : 2;
}
