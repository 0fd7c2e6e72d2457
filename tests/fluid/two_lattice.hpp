// The lattice Boltzmann equation written out on two lattices, one population at a time, with
// half-way walls: what the fast in-place code must agree with.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "ductile/fluid/d3q19.hpp"
#include "ductile/fluid/fluid.hpp"

namespace ductile::test {

class TwoLattice {
 public:
  explicit TwoLattice(const fluid::Options& options) : options_(options) {
    const auto& n = options.nodes;
    f_.resize(static_cast<std::size_t>(n[0] * n[1] * n[2]) * fluid::d3q19::Q);
    next_ = f_;
  }

  double& f(int i, int x, int y, int z) { return f_[index(i, x, y, z)]; }

  // `force` gives the force density at a node.
  void step(const std::function<Eigen::Vector3d(int, int, int)>& force) {
    using namespace fluid::d3q19;
    const auto& n = options_.nodes;
    const double omega_plus = 1 / options_.tau;
    const double omega_minus = options_.collision == fluid::Collision::bgk
                                   ? omega_plus
                                   : 1 / (0.5 + options_.magic / (options_.tau - 0.5));
    for (int x = 0; x < n[0]; ++x) {
      for (int y = 0; y < n[1]; ++y) {
        for (int z = 0; z < n[2]; ++z) {
          const Eigen::Vector3d F = force(x, y, z);
          double rho = 0;
          Eigen::Vector3d u = 0.5 * F;
          for (int i = 0; i < Q; ++i) {
            rho += f(i, x, y, z);
            u += f(i, x, y, z) * vector(i);
          }
          u /= rho;
          std::array<double, Q> equilibrium{};
          std::array<double, Q> forcing{};
          for (int i = 0; i < Q; ++i) {
            const double cu = vector(i).dot(u);
            const auto n_i = static_cast<std::size_t>(i);
            equilibrium[n_i] = w(i) * rho * (1 + 3 * cu + 4.5 * cu * cu - 1.5 * u.squaredNorm());
            forcing[n_i] = w(i) * (3 * (vector(i) - u) + 9 * cu * vector(i)).dot(F);
          }
          for (int i = 0; i < Q; ++i) {
            const auto a = static_cast<std::size_t>(i);
            const auto b = static_cast<std::size_t>(opposite(i));
            const double plus = 0.5 * (f(i, x, y, z) + f(opposite(i), x, y, z));
            const double minus = 0.5 * (f(i, x, y, z) - f(opposite(i), x, y, z));
            const double after = f(i, x, y, z) -
                                 omega_plus * (plus - 0.5 * (equilibrium[a] + equilibrium[b])) -
                                 omega_minus * (minus - 0.5 * (equilibrium[a] - equilibrium[b])) +
                                 (1 - 0.5 * omega_plus) * 0.5 * (forcing[a] + forcing[b]) +
                                 (1 - 0.5 * omega_minus) * 0.5 * (forcing[a] - forcing[b]);
            stream(i, {x, y, z}, after);
          }
        }
      }
    }
    f_.swap(next_);
  }

 private:
  static Eigen::Vector3d vector(int i) {
    const auto v = fluid::d3q19::c(i);
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
  }
  [[nodiscard]] std::size_t index(int i, int x, int y, int z) const {
    const auto& n = options_.nodes;
    const std::ptrdiff_t node = (static_cast<std::ptrdiff_t>(x) * n[1] + y) * n[2] + z;
    return static_cast<std::size_t>(node * fluid::d3q19::Q + i);
  }
  void stream(int i, const std::array<int, 3>& from, double value) {
    const auto v = fluid::d3q19::c(i);
    std::array<int, 3> to = from;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      to[axis] += v[axis];
      const int last = options_.nodes[axis] - 1;
      if (to[axis] >= 0 && to[axis] <= last) continue;
      if (options_.boundary[axis] == fluid::Boundary::periodic) {
        to[axis] = to[axis] < 0 ? last : 0;
        continue;
      }
      const auto& wall = options_.wall_velocity[axis][to[axis] < 0 ? 0 : 1];
      next_[index(fluid::d3q19::opposite(i), from[0], from[1], from[2])] =
          value - 6 * fluid::d3q19::w(i) * vector(i).dot(wall);
      return;
    }
    next_[index(i, to[0], to[1], to[2])] = value;
  }

  fluid::Options options_;
  std::vector<double> f_;
  std::vector<double> next_;
};

}  // namespace ductile::test
