// The lattice Boltzmann equation written out on two lattices, one population at a time, with
// half-way walls and walls on nodes: what the fast in-place code must agree with.
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

  struct State {
    double density;
    Eigen::Vector3d velocity;
  };
  // At a node about to collide under the force F.
  State state(int x, int y, int z, const Eigen::Vector3d& F) {
    State s{0, 0.5 * F};
    if (!on_wall(x, y)) {
      for (int i = 0; i < fluid::d3q19::Q; ++i) {
        s.density += f(i, x, y, z);
        s.velocity += f(i, x, y, z) * vector(i);
      }
      s.velocity /= weighing(s.density);
      return s;
    }
    // No mass passes: sum (1 - c.n_x)(1 - c.n_y) f of what arrives is that of what leaves.
    s.velocity = wall_velocity(x, y);
    s.density = -0.5 * (normal(0, x) + normal(1, y)).dot(F);
    for (int i = 0; i < fluid::d3q19::Q; ++i) {
      const double towards_x = 1 - vector(i).dot(normal(0, x));
      const double towards_y = 1 - vector(i).dot(normal(1, y));
      if (known(i, x, y)) s.density += towards_x * towards_y * f(i, x, y, z);
    }
    return s;
  }

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
          const auto [rho, u] = state(x, y, z, F);
          if (on_wall(x, y)) hold(x, y, z, F);
          std::array<double, Q> equilibrium{};
          std::array<double, Q> forcing{};
          for (int i = 0; i < Q; ++i) {
            const auto n_i = static_cast<std::size_t>(i);
            equilibrium[n_i] = equilibrium_of(i, rho, u);
            forcing[n_i] = w(i) * (3 * (vector(i) - u) + 9 * vector(i).dot(u) * vector(i)).dot(F);
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
  [[nodiscard]] double weighing(double density) const {
    return options_.equilibrium == fluid::Equilibrium::compressible ? density : 1;
  }
  [[nodiscard]] double equilibrium_of(int i, double rho, const Eigen::Vector3d& u) const {
    const double cu = vector(i).dot(u);
    return fluid::d3q19::w(i) *
           (rho + weighing(rho) * (3 * cu + 4.5 * cu * cu - 1.5 * u.squaredNorm()));
  }

  // Into the fluid, of a wall on nodes across an axis at that node; zero if there is none.
  [[nodiscard]] Eigen::Vector3d normal(std::size_t axis, int node) const {
    const bool low = node == 0;
    const bool high = node == options_.nodes[axis] - 1;
    Eigen::Vector3d n = Eigen::Vector3d::Zero();
    if (options_.boundary[axis] == fluid::Boundary::regularized && (low || high)) {
      n[static_cast<Eigen::Index>(axis)] = low ? 1 : -1;
    }
    return n;
  }
  [[nodiscard]] bool on_wall(int x, int y) const {
    return !normal(0, x).isZero() || !normal(1, y).isZero();
  }
  [[nodiscard]] bool on_edge(int x, int y) const {
    return !normal(0, x).isZero() && !normal(1, y).isZero();
  }
  [[nodiscard]] Eigen::Vector3d wall_velocity(int x, int y) const {
    const Eigen::Vector3d& across_x = options_.wall_velocity[0][x == 0 ? 0 : 1];
    const Eigen::Vector3d& across_y = options_.wall_velocity[1][y == 0 ? 0 : 1];
    if (on_edge(x, y)) return {0, 0, (across_x.z() + across_y.z()) / 2};
    return normal(0, x).isZero() ? across_y : across_x;
  }
  [[nodiscard]] bool known(int i, int x, int y) const {
    return vector(i).dot(normal(0, x)) <= 0 && vector(i).dot(normal(1, y)) <= 0;
  }
  // Replaces a wall node's populations (Latt et al. 2008).
  void hold(int x, int y, int z, const Eigen::Vector3d& F) {
    using namespace fluid::d3q19;
    const auto [rho, u] = state(x, y, z, F);
    Eigen::Matrix3d stress = Eigen::Matrix3d::Zero();
    for (int i = 0; i < Q && !on_edge(x, y); ++i) {
      const int from = known(i, x, y) ? i : opposite(i);
      const double rest =
          f(from, x, y, z) - equilibrium_of(from, rho, u) + 1.5 * w(from) * vector(from).dot(F);
      stress += rest * vector(i) * vector(i).transpose();
    }
    for (int i = 0; i < Q; ++i) {
      const double along = vector(i).dot(stress * vector(i)) - stress.trace() / 3;
      f(i, x, y, z) = equilibrium_of(i, rho, u) + w(i) * (4.5 * along - 1.5 * vector(i).dot(F));
    }
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
      if (options_.boundary[axis] == fluid::Boundary::regularized) return;
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
