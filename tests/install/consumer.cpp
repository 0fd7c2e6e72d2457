// Inflates a capsule by 5% and prints its tension over k_s: (1/3) [(l^2 - 1) + C l^2 (l^4 - 1)].
#include <petscsys.h>

#include <cmath>
#include <cstdio>

#include "ductile/membrane/shell.hpp"
#include "ductile/surface/mesh.hpp"

namespace {

// The pressure that the vertex forces of an inflated sphere make, p = -F.n/A, gives T = p a l/2.
double tension() {
  using namespace ductile::membrane;
  const ductile::surface::Mesh reference = ductile::surface::icosphere(16, 1.0);
  const Shell shell(reference, {.k_s = 1, .k_a = 2});
  constexpr double l = 1.05;
  const VecPtr x = shell.create_vec();
  const VecPtr f = shell.create_vec();
  {
    const VecArray<double> position(x.get());
    for (std::size_t v = 0; v < reference.vertices.size(); ++v) {
      for (std::size_t a = 0; a < 3; ++a) {
        position[3 * v + a] = l * reference.vertices[v][static_cast<Eigen::Index>(a)];
      }
    }
  }
  shell.force(x.get(), f.get());
  const VecArray<const double> force(f.get());
  double inward = 0;
  for (std::size_t v = 0; v < reference.vertices.size(); ++v) {
    for (std::size_t a = 0; a < 3; ++a) {
      inward -= force[3 * v + a] * reference.vertices[v][static_cast<Eigen::Index>(a)];
    }
  }
  const double pressure = inward / (l * l * area(reference));
  return pressure * l / 2;
}

}  // namespace

int main(int argc, char** argv) {
  if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0) return 1;
  const double t = tension();
  std::printf("T/k_s = %.5f\n", t);
  if (PetscFinalize() != 0) return 1;
  return std::abs(t / 0.1925638 - 1) < 0.005 ? 0 : 1;
}
