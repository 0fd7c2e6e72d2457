// Microseconds per call of what a membrane solver calls: force, tangent, tangent times a vector.
// Sphere and biconcave cell, every modulus in play, 5% off their reference. Best of several.
#include <petscmat.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <random>

#include "ductile/membrane/petsc.hpp"
#include "ductile/membrane/shell.hpp"
#include "ductile/surface/biconcave.hpp"
#include "ductile/surface/mesh.hpp"

namespace {

using ductile::membrane::petsc_check;
using Clock = std::chrono::steady_clock;

/// Contenders take turns, so that the machine's moods meet all of them.
template <class... Calls>
void measure(int frequency, const char* shape, std::size_t triangles, Calls... calls) {
  constexpr int rounds = 30;
  const int repeats = std::max(1, 100000 / static_cast<int>(triangles));
  double best[sizeof...(calls)];
  std::fill(std::begin(best), std::end(best), 1e30);
  for (int round = 0; round < rounds; ++round) {
    int k = 0;
    const auto time = [&](auto& call) {
      const auto start = Clock::now();
      for (int i = 0; i < repeats; ++i) call();
      const std::chrono::duration<double, std::micro> taken = Clock::now() - start;
      best[k] = std::min(best[k], taken.count() / repeats);
      ++k;
    };
    (time(calls), ...);
  }
  std::printf("%-10s %9d %9zu", shape, frequency, triangles);
  for (const double microseconds : best) std::printf(" %9.1f", microseconds);
  std::printf("\n");
}

void bench(int frequency, const char* shape, const ductile::surface::Mesh& mesh) {
  const ductile::membrane::Shell shell(mesh, {.k_s = 1, .k_a = 2, .k_b = .1, .k_v = 1});
  const auto x = shell.create_vec(), f = shell.create_vec(), y = shell.create_vec();
  {
    std::mt19937 generator(1);
    std::uniform_real_distribution<double> noise(-.05, .05);
    const ductile::membrane::VecArray<double> array(x.get());
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      for (int k = 0; k < 3; ++k) array[3 * i + k] = mesh.vertices[i][k] + noise(generator);
    }
  }
  const auto k = shell.create_tangent();
  measure(
      frequency, shape, mesh.triangles.size(), [&] { shell.force(x.get(), f.get()); },
      [&] { shell.tangent(x.get(), k.get()); },
      [&] { petsc_check(MatMult(k.get(), f.get(), y.get())); });
}

}  // namespace

int main(int argc, char** argv) {
  if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0) return 1;
  int failed = 0;
  try {
    std::printf("%-10s %9s %9s %9s %9s %9s\n", "shape", "frequency", "triangles", "force",
                "tangent", "MatMult");
    for (const int frequency : {7, 16, 32}) {
      const double radius = frequency / 1.2;  // edges of about 1
      bench(frequency, "sphere", ductile::surface::icosphere(frequency, radius));
      bench(frequency, "biconcave", ductile::surface::Biconcave(radius).mesh(frequency));
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    failed = 1;
  }
  return PetscFinalize() == 0 ? failed : 1;
}
