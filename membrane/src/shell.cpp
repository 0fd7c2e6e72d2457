#include "ductile/membrane/shell.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "force.hpp"
#include "shell_math.hpp"

namespace ductile::membrane {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;
using std::numbers::sqrt3;

void validate(const Moduli& moduli) {
  const std::pair<const char*, double> all[] = {
      {"k_s", moduli.k_s}, {"k_a", moduli.k_a}, {"k_b", moduli.k_b}, {"k_v", moduli.k_v}};
  for (const auto& [name, value] : all) {
    if (!(value >= 0) || !std::isfinite(value)) {
      throw std::invalid_argument(std::string("shell: modulus ") + name + " = " +
                                  std::to_string(value) + " must be finite and not negative");
    }
  }
}

ForceModuli force_moduli(const Moduli& moduli) {
  const auto with = [&](bool skalak) {
    return ForceModuli{skalak, moduli.k_s, moduli.k_a, sqrt3 * moduli.k_b};
  };
  switch (moduli.law) {
    case StrainLaw::skalak:
      return with(true);
    case StrainLaw::neo_hookean:
      break;
  }
  return with(false);
}

std::string quoted(const std::array<int, 3>& triangle) {
  return "(" + std::to_string(triangle[0]) + ", " + std::to_string(triangle[1]) + ", " +
         std::to_string(triangle[2]) + ")";
}

void validate(const surface::Mesh& mesh) {
  if (mesh.triangles.empty()) throw std::invalid_argument("shell: the mesh has no triangles");
  const auto vertex_count = static_cast<int>(mesh.vertices.size());
  std::vector<bool> used(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const int vertex : mesh.triangles[t]) {
      if (vertex < 0 || vertex >= vertex_count) {
        throw std::invalid_argument(
            "shell: triangle " + std::to_string(t) + " " + quoted(mesh.triangles[t]) +
            " names a vertex that is not one of " + std::to_string(vertex_count));
      }
      used[vertex] = true;
    }
  }
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v])
      throw std::invalid_argument("shell: vertex " + std::to_string(v) + " belongs to no triangle");
  }
}

}  // namespace

Shell::Shell(const surface::Mesh& reference, const Moduli& moduli, const ShellOptions& options)
    : vertex_count_(static_cast<int>(reference.vertices.size())),
      moduli_(moduli),
      triangles_(reference.triangles),
      open_sheet_(options.open_sheet),
      normals_(reference.triangles.size()),
      inverse_norms_(reference.triangles.size()) {
  validate(moduli);
  validate(reference);
  build_elements(reference);
  build_hinges(options);
  moments_.resize(hinges_.size() + 1);

  std::vector<double> x;
  x.reserve(3 * reference.vertices.size());
  for (const Vector3d& vertex : reference.vertices) x.insert(x.end(), vertex.begin(), vertex.end());
  reference_volume_ = update_normals(x.data());
  if (!options.flat_reference_angles) {
    for (Hinge& hinge : hinges_) {
      const Angle theta0 = angle(hinge, x.data());
      hinge.cos0 = theta0.cos;
      hinge.sin0 = theta0.sin;
    }
  }
  vertex_areas_ = surface::vertex_areas(reference);
  make_force(options.instruction_set);

  if (options.open_sheet && moduli.k_v > 0) {
    throw std::invalid_argument("shell: an open sheet encloses no volume: k_v = " +
                                std::to_string(moduli.k_v) + " must be 0");
  }
  if (!options.open_sheet && !(reference_volume_ > 0)) {
    throw std::invalid_argument("shell: the mesh encloses the volume " +
                                std::to_string(reference_volume_) +
                                ": its triangles must run counter-clockwise seen from outside");
  }
}

void Shell::build_elements(const surface::Mesh& reference) {
  elements_.reserve(triangles_.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& [v0, v1, v2] = triangles_[t];
    const Vector3d e1 = reference.vertices[v1] - reference.vertices[v0];
    const Vector3d e2 = reference.vertices[v2] - reference.vertices[v0];
    const double g11 = e1.squaredNorm(), g12 = e1.dot(e2), g22 = e2.squaredNorm();
    const double det = e1.cross(e2).squaredNorm();
    // Round-off in det is a few eps (g11 + g22)^2; a height of 1e-6 edges stays well above.
    if (!(det > 1e-12 * (g11 + g22) * (g11 + g22))) {
      throw std::invalid_argument("shell: triangle " + std::to_string(t) + " " +
                                  quoted(triangles_[t]) + " is degenerate: its area is " +
                                  std::to_string(std::sqrt(det) / 2));
    }
    elements_.push_back({g22 / det, -g12 / det, g11 / det, 1 / det, std::sqrt(det) / 2, {}});
  }
}

void Shell::build_hinges(const ShellOptions& options) {
  struct Side {
    int triangle, corner;  // the corner that faces the edge
  };
  std::map<std::pair<int, int>, Side> sides;  // by (tail, head)
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int tail = triangles_[t][(k + 1) % 3], head = triangles_[t][(k + 2) % 3];
      const auto [entry, is_new] = sides.try_emplace({tail, head}, Side{static_cast<int>(t), k});
      if (!is_new) {
        throw std::invalid_argument("shell: triangles " + std::to_string(entry->second.triangle) +
                                    " and " + std::to_string(t) + " both run from vertex " +
                                    std::to_string(tail) + " to " + std::to_string(head) +
                                    ": one is flipped, or the edge has more than two triangles");
      }
    }
  }
  // In the order of the triangles, which keeps the work on neighbours together.
  for (Element& element : elements_) element.hinges.fill(-1);
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      if (elements_[t].hinges[k] >= 0) continue;
      const int tail = triangles_[t][(k + 1) % 3], head = triangles_[t][(k + 2) % 3];
      const auto other = sides.find({head, tail});
      if (other != sides.end()) {
        const auto& [right, corner] = other->second;
        const auto number = static_cast<int>(hinges_.size());
        elements_[t].hinges[k] = number;
        elements_[right].hinges[corner] = number;
        hinges_.push_back({static_cast<int>(t), right, tail, head, 1, 0});
      } else if (!options.open_sheet) {
        throw std::invalid_argument("shell: the mesh is not closed: the edge from vertex " +
                                    std::to_string(tail) + " to " + std::to_string(head) +
                                    " of triangle " + std::to_string(t) + " has no other triangle");
      }
    }
  }
  for (Element& element : elements_) {
    for (int& hinge : element.hinges) {
      if (hinge < 0) hinge = static_cast<int>(hinges_.size());
    }
  }
}

void Shell::make_force(InstructionSet set) {
  std::vector<Force::Triangle> triangles;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& [v0, v1, v2] = triangles_[t];
    const Element& e = elements_[t];
    triangles.push_back({{v0, v1, v2},
                         {e.hinges[0], e.hinges[1], e.hinges[2]},
                         e.a11,
                         e.a12,
                         e.a22,
                         e.inverse_det,
                         e.area});
  }
  std::vector<Force::Edge> edges;
  for (const Hinge& h : hinges_) edges.push_back({h.left, h.right, h.tail, h.head, h.cos0, h.sin0});
  force_ = std::make_shared<Force>(triangles, edges, vertex_count_, set);
}

double Shell::update_normals(const double* x) const {
  const Vector3d origin = point(x, 0);  // near the shell, lest its distance cost digits
  double volume = 0;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& [v0, v1, v2] = triangles_[t];
    const Vector3d x0 = point(x, v0);
    normals_[t] = (point(x, v1) - x0).cross(point(x, v2) - x0);
    inverse_norms_[t] = 1 / std::sqrt(normals_[t].squaredNorm());
    volume += (x0 - origin).dot(normals_[t]);
  }
  return volume / 6;
}

double Shell::pressure(double volume) const {
  return moduli_.k_v > 0 ? moduli_.k_v * (volume - reference_volume_) / reference_volume_ : 0;
}

Energies Shell::energies(Vec positions) const {
  const auto array = array_of<const double>(positions, vertex_count_);
  const double* x = array.data();
  Energies energies;

  const double v = update_normals(x) - reference_volume_;
  if (moduli_.k_v > 0) energies.volume = moduli_.k_v / 2 * v * v / reference_volume_;

  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto& [v0, v1, v2] = triangles_[t];
    const Element& e = elements_[t];
    const Vector3d e1 = point(x, v1) - point(x, v0), e2 = point(x, v2) - point(x, v0);
    const double i1 =
        e1.squaredNorm() * e.a11 + 2 * e1.dot(e2) * e.a12 + e2.squaredNorm() * e.a22 - 2;
    const double i2 = normals_[t].squaredNorm() * e.inverse_det - 1;
    energies.strain += e.area * strain_density(moduli_, i1, i2).w;
  }

  for (const Hinge& hinge : hinges_) {
    // 1 - cos(theta - theta0), without its cancellation.
    const Angle theta = angle(hinge, x);
    const double c = theta.cos - hinge.cos0, s = theta.sin - hinge.sin0;
    energies.bending += (c * c + s * s) / 2;
  }
  energies.bending *= sqrt3 * moduli_.k_b;
  return energies;
}

void Shell::force(Vec positions, Vec force) const {
  const auto x = array_of<const double>(positions, vertex_count_);
  const auto f = array_of<double>(force, vertex_count_);
  const double p = pressure(force_->start(x.data()));
  force_->finish(force_moduli(moduli_), p, f.data());
}

Shape Shell::shape(Vec positions) const {
  const auto array = array_of<const double>(positions, vertex_count_);
  return shape(std::span(array.data(), 3 * static_cast<std::size_t>(vertex_count_)));
}

Shape Shell::shape(std::span<const double> positions) const {
  if (positions.size() != 3 * static_cast<std::size_t>(vertex_count_)) {
    throw std::invalid_argument("shell: " + std::to_string(positions.size()) + " numbers where " +
                                std::to_string(3 * vertex_count_) + " are needed");
  }
  const double* x = positions.data();
  const Vector3d origin = point(x, 0);
  Shape shape;
  Vector3d first = Vector3d::Zero();   // integrals of x and x x^T, a tetrahedron from the
  Matrix3d second = Matrix3d::Zero();  // origin to each triangle
  for (const auto& [v0, v1, v2] : triangles_) {
    const Vector3d a = point(x, v0) - origin, b = point(x, v1) - origin, c = point(x, v2) - origin;
    const Vector3d sum = a + b + c;
    const double volume = a.dot(b.cross(c)) / 6;
    shape.area += (b - a).cross(c - a).norm() / 2;
    shape.volume += volume;
    first += volume / 4 * sum;
    second += volume / 20 *
              (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
  }
  const Vector3d centre = first / shape.volume;
  shape.centroid = origin + centre;
  shape.inertia = second - shape.volume * centre * centre.transpose();
  return shape;
}

Vector3d Shape::semi_axes() const {
  // An ellipsoid with semi-axes a, b, c has (4 pi/15) a b c (a^2, b^2, c^2).
  const Vector3d moments = Eigen::SelfAdjointEigenSolver<Matrix3d>(inertia, Eigen::EigenvaluesOnly)
                               .eigenvalues()
                               .reverse() *
                           (15 / (4 * pi));
  return (moments / std::pow(moments.prod(), 0.2)).cwiseSqrt();
}

Vector3d Shape::shortest_axis() const {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(inertia);
  const Vector3d& moments = solver.eigenvalues();
  const bool distinct = moments[1] - moments[0] > 1e-9 * moments[2];
  return distinct ? Vector3d(solver.eigenvectors().col(0)) : Vector3d(Vector3d::Zero());
}

double Shape::taylor_deformation() const {
  const Vector3d axes = semi_axes();
  return (axes[0] - axes[2]) / (axes[0] + axes[2]);
}

}  // namespace ductile::membrane
