#include "ductile/surface/mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace ductile::surface {
namespace {

using Eigen::Vector3d;

Mesh icosahedron() {
  constexpr double phi = std::numbers::phi;
  Mesh mesh;
  mesh.vertices = {{-1, phi, 0}, {1, phi, 0}, {-1, -phi, 0}, {1, -phi, 0},
                   {0, -1, phi}, {0, 1, phi}, {0, -1, -phi}, {0, 1, -phi},
                   {phi, 0, -1}, {phi, 0, 1}, {-phi, 0, -1}, {-phi, 0, 1}};
  for (Vector3d& x : mesh.vertices) x.normalize();
  mesh.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  return mesh;
}

// Divides each edge of a mesh of the unit sphere into `parts`, each triangle into parts^2; new
// vertices are projected onto the sphere.
Mesh divide(const Mesh& coarse, int parts) {
  Mesh fine;
  fine.vertices = coarse.vertices;
  const auto add = [&](const Vector3d& x) {
    fine.vertices.push_back(x.normalized());
    return static_cast<int>(fine.vertices.size()) - 1;
  };

  // First of the parts - 1 new vertices of an edge, which run from its lower to its higher end.
  std::map<std::pair<int, int>, int> first_on_edge;
  const auto on_edge = [&](int from, int to, int step) {
    const auto [low, high] = std::minmax(from, to);
    const auto [entry, is_new] =
        first_on_edge.try_emplace({low, high}, static_cast<int>(fine.vertices.size()));
    if (is_new) {
      for (int s = 1; s < parts; ++s)
        add((parts - s) * coarse.vertices[low] + s * coarse.vertices[high]);
    }
    return entry->second + (from < to ? step : parts - step) - 1;
  };

  std::vector<int> ids(static_cast<std::size_t>((parts + 1) * (parts + 1)));
  const auto id = [&](int i, int j) -> int& { return ids[i * (parts + 1) + j]; };
  for (const auto& [a, b, c] : coarse.triangles) {
    // Lattice point (i, j) lies i steps from a towards b and j steps towards c.
    for (int i = 0; i <= parts; ++i) {
      for (int j = 0; i + j <= parts; ++j) {
        const int k = parts - i - j;
        if (k == parts) {
          id(i, j) = a;
        } else if (i == parts) {
          id(i, j) = b;
        } else if (j == parts) {
          id(i, j) = c;
        } else if (j == 0) {
          id(i, j) = on_edge(a, b, i);
        } else if (i == 0) {
          id(i, j) = on_edge(a, c, j);
        } else if (k == 0) {
          id(i, j) = on_edge(b, c, j);
        } else {
          id(i, j) = add(k * coarse.vertices[a] + i * coarse.vertices[b] + j * coarse.vertices[c]);
        }
      }
    }
    for (int i = 0; i < parts; ++i) {
      for (int j = 0; i + j < parts; ++j) {
        fine.triangles.push_back({id(i, j), id(i + 1, j), id(i, j + 1)});
        if (i + j + 1 < parts)
          fine.triangles.push_back({id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)});
      }
    }
  }
  return fine;
}

// Twice the area, along the outward normal.
Vector3d normal(const Mesh& mesh, const std::array<int, 3>& triangle) {
  const Vector3d& x0 = mesh.vertices[triangle[0]];
  return (mesh.vertices[triangle[1]] - x0).cross(mesh.vertices[triangle[2]] - x0);
}

}  // namespace

Mesh icosphere(int frequency, double radius) {
  constexpr int max_frequency = 10362;  // 20 n^2 fits an int
  if (frequency < 1 || frequency > max_frequency) {
    throw std::invalid_argument("icosphere: frequency " + std::to_string(frequency) +
                                " is not between 1 and " + std::to_string(max_frequency));
  }
  if (!(radius > 0) || !std::isfinite(radius))
    throw std::invalid_argument("icosphere: radius " + std::to_string(radius) + " is not positive");
  int odd = frequency;
  while (odd % 2 == 0) odd /= 2;
  Mesh mesh = divide(icosahedron(), odd);
  for (int n = odd; n < frequency; n *= 2) mesh = divide(mesh, 2);
  for (Vector3d& x : mesh.vertices) x *= radius;
  return mesh;
}

double mean_edge(const Mesh& mesh) {
  double sum = 0;  // every edge twice
  for (const auto& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k)
      sum += (mesh.vertices[triangle[(k + 1) % 3]] - mesh.vertices[triangle[k]]).norm();
  }
  return sum / static_cast<double>(3 * mesh.triangles.size());
}

int frequency_for_edge(double radius, double edge) {
  if (!(radius > 0) || !(edge > 0) || !std::isfinite(radius / edge)) {
    throw std::invalid_argument("frequency_for_edge: radius " + std::to_string(radius) +
                                " and edge " + std::to_string(edge) + " must be positive");
  }
  const int guess = static_cast<int>(std::min(icosphere_edge(radius, 1) / edge, 1e6));
  int best = 2;
  double best_error = std::abs(mean_edge(icosphere(best, radius)) - edge);
  for (int n = std::max(3, guess - 1); n <= guess + 2; ++n) {
    const double error = std::abs(mean_edge(icosphere(n, radius)) - edge);
    if (error < best_error) {
      best = n;
      best_error = error;
    }
  }
  return best;
}

double volume(const Mesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    sum += mesh.vertices[a].dot(mesh.vertices[b].cross(mesh.vertices[c]));
  return sum / 6;
}

double area(const Mesh& mesh) {
  double sum = 0;
  for (const auto& triangle : mesh.triangles) sum += normal(mesh, triangle).norm();
  return sum / 2;
}

std::vector<double> vertex_areas(const Mesh& mesh) {
  std::vector<double> areas(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles) {
    const double third = normal(mesh, triangle).norm() / 6;
    for (const int vertex : triangle) areas[vertex] += third;
  }
  return areas;
}

void place(Mesh& mesh, const Eigen::Matrix3d& rotation, const Vector3d& centre) {
  for (Vector3d& x : mesh.vertices) x = rotation * x + centre;
}

}  // namespace ductile::surface
