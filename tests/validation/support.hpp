// Bodies in a fluid, put together for tests.
#pragma once

#include <array>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "ductile/coupling/coupler.hpp"
#include "ductile/fluid/fluid.hpp"
#include "ductile/surface/mesh.hpp"
#include "ductile/surface/sphere.hpp"
#include "ductile/suspension/markers.hpp"
#include "ductile/suspension/plan.hpp"

namespace ductile::test {

inline fluid::Options box(int nx, int ny, int nz, double tau) {
  fluid::Options options;
  options.nodes = {nx, ny, nz};
  options.tau = tau;
  return options;
}

/// How far inside of its surface a rigid body's markers stand in for it, in lattice spacings: the
/// 4-point kernel makes the body felt so much further out (SphereArray measures it).
constexpr double retraction = 0.5;
/// The same for radii of about five spacings, where the drag in an array is right with this.
constexpr double retraction_small = 0.6;
/// The same for the drag of a body that inner shells make solid.
constexpr double retraction_solid = 0.7;

using suspension::Interior;

/// A sphere with markers about 1.2 apart, `inwards` of its surface, in that state. `missed` as of
/// rigid::Surface.
inline rigid::Body sphere(double radius, const rigid::Options& options, const rigid::State& state,
                          double inwards, Interior interior, double missed = 0) {
  const surface::Sphere shape(radius);
  const int frequency = surface::frequency_for_edge(radius - inwards, 1.2);
  return {interior == Interior::solid ? rigid::lined(shape, frequency, inwards, missed)
                                      : rigid::markers_of(shape.mesh(frequency, -inwards), missed),
          rigid::solid_of(shape), options, state};
}

inline rigid::Body sphere(double radius, const rigid::Options& options, const Eigen::Vector3d& at,
                          double inwards = retraction, Interior interior = Interior::fluid,
                          double missed = 0) {
  rigid::State state;
  state.position = at;
  return sphere(radius, options, state, inwards, interior, missed);
}

/// A spherical capsule, inflated from its reference by `stretch`.
inline std::unique_ptr<membrane::Capsule> capsule(double radius, double stretch,
                                                  const membrane::Moduli& moduli,
                                                  const membrane::CapsuleOptions& options,
                                                  const Eigen::Vector3d& at, double edge) {
  const int n = surface::frequency_for_edge(radius, edge);
  const surface::Mesh reference = surface::icosphere(n, radius);
  surface::Mesh placed = surface::icosphere(n, radius * stretch);
  surface::place(placed, Eigen::Matrix3d::Identity(), at);
  return std::make_unique<membrane::Capsule>(reference, placed.vertices, moduli, options);
}

/// Rows of two numbers, separated by a comma or a blank, from tests/reference.
inline std::vector<std::array<double, 2>> reference_curve(const std::string& file) {
  std::ifstream in(std::string(DUCTILE_REFERENCE_DIR) + "/" + file);
  if (!in) throw std::runtime_error("cannot read " + file);
  std::vector<std::array<double, 2>> rows;
  for (std::string line; std::getline(in, line);) {
    for (char& c : line) c = c == ',' ? ' ' : c;
    std::array<double, 2> row{};
    if (std::istringstream(line) >> row[0] >> row[1]) rows.push_back(row);
  }
  return rows;
}

}  // namespace ductile::test
