// A red blood cell pulled at two ends of its rim, as optical tweezers do.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "ductile/membrane/equilibrium.hpp"
#include "ductile/surface/biconcave.hpp"
#include "ductile/surface/mesh.hpp"

namespace {

using namespace ductile::membrane;
using Eigen::Vector3d;

// Micrometres and piconewtons throughout.
using Curve = std::vector<std::pair<double, double>>;  // force, diameter

Curve read(const std::string& name) {
  std::ifstream file(std::string(DUCTILE_REFERENCE_DIR) + "/rbc_optical_stretching/" + name);
  EXPECT_TRUE(file) << name;
  Curve curve;
  std::string line;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    double force = 0, diameter = 0;
    if (std::istringstream(line) >> force >> diameter) curve.emplace_back(force, diameter);
  }
  std::sort(curve.begin(), curve.end());
  return curve;
}

double interpolated(const Curve& curve, double force) {
  const auto above = std::lower_bound(curve.begin(), curve.end(), std::pair{force, 0.});
  const auto below = above - 1;
  const double weight = (force - below->first) / (above->first - below->first);
  return (1 - weight) * below->second + weight * above->second;
}

// The experiments' mean and its bounds, read at common forces: of each group, the least and the
// largest diameter of those along (above `divide`) or across.
std::array<Curve, 2> bounds(bool along) {
  constexpr double divide = 7.5;
  std::array<Curve, 2> result;
  double last = -std::numeric_limits<double>::infinity();
  for (const auto& [force, diameter] : read("reference-bounds.dat")) {
    if (force < 5 || (diameter > divide) != along) continue;
    if (force - last > 2) {
      for (Curve& curve : result) curve.emplace_back(force, diameter);
      last = force;
    }
    result[0].back().second = std::min(result[0].back().second, diameter);
    result[1].back().second = std::max(result[1].back().second, diameter);
  }
  return result;
}

// The cell of eq. (18), R0 = 3.91 um. G_s is 4 uN/m, which Hochmuth & Hampel (J. Rheol. 23, 669,
// 1979) found by pulling cells at opposite points of the rim; k_s is 3 G_s. (The literature has 2
// to 10 uN/m; what the reference curves rest on is not known. With 5.3 the cell is 10.48, 12.53 and
// 15.04 um long below; with k_s = 5.3, it is 13.4 um long at 38 pN, outside the bounds.) C = 50
// keeps the area to half a per cent (a real cell's C is of the order of 1e5), k_v the volume to a
// thousandth; kappa is 2.5e-19 J, k_b = kappa/1.5. C, kappa and k_v hardly matter to the diameters.
constexpr double shear_modulus = 4;
const Moduli moduli{.law = StrainLaw::skalak,
                    .k_s = 3 * shear_modulus,
                    .k_a = 50 * 3 * shear_modulus,
                    .k_b = .25 / 1.5,
                    .k_v = 2000};

class Stretched {
 public:
  explicit Stretched(int frequency)
      : mesh_(ductile::surface::Biconcave(3.91 / 1.2).mesh(frequency)),
        shell_(mesh_, moduli),
        x_(shell_.create_vec()) {
    VecArray<double> x(x_.get());
    for (std::size_t i = 0; i < mesh_.vertices.size(); ++i)
      Vector3d::Map(&x[3 * i]) = mesh_.vertices[i];
  }

  // Pulls along x at 5% of the vertices at either end, all of a row or none.
  Equilibrium pull(double force) {
    std::vector<double> along;
    for (const Vector3d& v : mesh_.vertices) along.push_back(v[0]);
    std::sort(along.rbegin(), along.rend());
    const double cut = along[along.size() / 20] - 1e-9;
    const auto count =
        std::count_if(along.begin(), along.end(), [&](double v) { return v >= cut; });
    const VecPtr f = shell_.create_vec();
    {
      VecArray<double> array(f.get());
      for (std::size_t i = 0; i < mesh_.vertices.size(); ++i) {
        const double v = mesh_.vertices[i][0];
        if (std::abs(v) >= cut) array[3 * i] = std::copysign(force / static_cast<double>(count), v);
      }
    }
    return find_equilibrium(shell_, f.get(), x_.get());
  }

  // Along the pull, and twice the largest distance from its axis.
  [[nodiscard]] std::array<double, 2> diameters() const {
    const VecArray<const double> x(x_.get());
    double least = 0, largest = 0, radius = 0;
    for (std::size_t i = 0; i < mesh_.vertices.size(); ++i) {
      least = std::min(least, x[3 * i]);
      largest = std::max(largest, x[3 * i]);
      radius = std::max(radius, std::hypot(x[3 * i + 1], x[3 * i + 2]));
    }
    return {largest - least, 2 * radius};
  }
  [[nodiscard]] double volume_error() const {
    return shell_.shape(x_.get()).volume / shell_.reference_volume() - 1;
  }
  [[nodiscard]] double area_error() const { return shell_.shape(x_.get()).area / area(mesh_) - 1; }

 private:
  ductile::surface::Mesh mesh_;
  Shell shell_;
  VecPtr x_;
};

// The measurements scatter by about 10% along and 10 to 15% across, and end at their bounds.
// Across, at small forces, the reference curve lies above the upper one (6.32 and 5.99 um at 38 pN)
// and so do we, by 5%; from 87 pN on we are 9% above that curve, which at 87 pN is 3% above the
// bound.
TEST(OpticalStretching, RedCellLengthensAsMeasured) {
  Stretched cell(10);
  EXPECT_NEAR(cell.diameters()[0], 2 * 3.91, .01 * 7.82);
  const Curve axial = read("reference-axial.dat"), transverse = read("reference-transverse.dat");
  const auto axial_bounds = bounds(true), transverse_bounds = bounds(false);
  for (const double force : {38, 87, 173}) {
    const Equilibrium found = cell.pull(force);
    EXPECT_EQ(found.unstable_modes, 0);
    const auto [along, across] = cell.diameters();
    const double reference_along = interpolated(axial, force);
    const double reference_across = interpolated(transverse, force);
    std::printf(
        "%g pN: along %.2f (curve %.2f, measured %.2f to %.2f), across %.2f (curve %.2f, "
        "measured %.2f to %.2f); area %+.2f%%, volume %+.2f%%; %d Newton iterations\n",
        force, along, reference_along, interpolated(axial_bounds[0], force),
        interpolated(axial_bounds[1], force), across, reference_across,
        interpolated(transverse_bounds[0], force), interpolated(transverse_bounds[1], force),
        100 * cell.area_error(), 100 * cell.volume_error(), found.newton_iterations);
    EXPECT_GT(along, interpolated(axial_bounds[0], force));
    EXPECT_LT(along, interpolated(axial_bounds[1], force));
    EXPECT_NEAR(along / reference_along, 1, .03);
    EXPECT_NEAR(across / reference_across, 1, .12);
    EXPECT_GT(across, interpolated(transverse_bounds[0], force));
    EXPECT_LT(across, 1.06 * interpolated(transverse_bounds[1], force));
    EXPECT_NEAR(cell.area_error(), 0, .005);
    EXPECT_NEAR(cell.volume_error(), 0, .001);
  }
}

}  // namespace
