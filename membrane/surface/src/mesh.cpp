#include "ductile/surface/mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
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

namespace {

// n times the mean edge of the icosphere of frequency n and radius 1, for n = 1 to 32.
constexpr std::array<double, 32> edge_numbers = {
    1.051462224238, 1.164567046575, 1.185840523962, 1.197328301274, 1.196867827723, 1.200795202980,
    1.199925592225, 1.205837641559, 1.201186518272, 1.202330547322, 1.201825381398, 1.204598736307,
    1.202193001468, 1.202724086224, 1.202423716127, 1.207985572824, 1.202577934967, 1.202882292745,
    1.202686083553, 1.203704783434, 1.202764838386, 1.202961541191, 1.202823960599, 1.205553732856,
    1.202869471981, 1.203006865948, 1.202905250926, 1.203425948148, 1.202933886766, 1.203035207940,
    1.202957161692, 1.208523853373};

// Of larger ones. Each division of all edges in two brings what n lacks to its limit down to a
// quarter; meshes divided into many at once all have one limit.
double edge_number(int n) {
  if (n <= 32) return edge_numbers[static_cast<std::size_t>(n) - 1];
  const double square = static_cast<double>(n) * n;
  if (n % 2 != 0) return 1.20312 - 0.155 / square;
  if (n % 4 != 0) return 1.20312 - 0.077 / square;
  return edge_number(n / 2) + (edge_number(n / 2) - edge_number(n / 4)) / 4;
}

}  // namespace

double icosphere_mean_edge(int frequency, double radius) {
  if (frequency < 1 || !(radius > 0)) {
    throw std::invalid_argument("icosphere_mean_edge: frequency " + std::to_string(frequency) +
                                " and radius " + std::to_string(radius) + " must be positive");
  }
  return radius * edge_number(frequency) / frequency;
}

int frequency_for_edge(double radius, double edge) {
  if (!(radius > 0) || !(edge > 0) || !std::isfinite(radius / edge)) {
    throw std::invalid_argument("frequency_for_edge: radius " + std::to_string(radius) +
                                " and edge " + std::to_string(edge) + " must be positive");
  }
  const int guess = static_cast<int>(std::min(icosphere_edge(radius, 1) / edge, 1e6));
  const auto error = [&](int n) { return std::abs(icosphere_mean_edge(n, radius) - edge); };
  int best = 2;
  for (int n = std::max(3, guess - 1); n <= guess + 2; ++n) {
    if (error(n) < error(best)) best = n;
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

std::vector<Vector3d> vertex_normals(std::span<const double> positions,
                                     std::span<const std::array<int, 3>> triangles) {
  const auto vertex = [&](int v) {
    return Vector3d::Map(&positions[3 * static_cast<std::size_t>(v)]);
  };
  std::vector<Vector3d> normals(positions.size() / 3, Vector3d::Zero());
  for (const auto& [a, b, c] : triangles) {
    const Vector3d normal = (vertex(b) - vertex(a)).cross(vertex(c) - vertex(a));
    for (const int v : {a, b, c}) normals[static_cast<std::size_t>(v)] += normal;
  }
  for (Vector3d& normal : normals) normal.normalize();
  return normals;
}

std::vector<double> offset(std::span<const double> positions,
                           std::span<const std::array<int, 3>> triangles, double distance) {
  std::vector<double> moved(positions.begin(), positions.end());
  if (distance == 0) return moved;
  const std::vector<Vector3d> normals = vertex_normals(positions, triangles);
  for (std::size_t v = 0; v < normals.size(); ++v)
    Vector3d::Map(&moved[3 * v]) += distance * normals[v];
  return moved;
}

void place(Mesh& mesh, const Eigen::Matrix3d& rotation, const Vector3d& centre) {
  for (Vector3d& x : mesh.vertices) x = rotation * x + centre;
}

}  // namespace ductile::surface
