// Closed triangle meshes and their geometry.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace ductile::surface {

/// A closed surface of triangles, normals outward (vertices counter-clockwise seen from outside).
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
};

/// Geodesic icosphere of `frequency` n: 20 n^2 triangles, 10 n^2 + 2 vertices on the sphere of
/// `radius` about the origin. n = m 2^k, m odd: each face of the icosahedron is divided into m^2,
/// projected, and then k times each triangle into four, new vertices projected onto the sphere at
/// every level (Krueger, Varnik & Raabe 2011; the paper's 20 x 4^k meshes are n = 2^k).
/// The numbering depends on n alone. Throws std::invalid_argument if n < 1, if 20 n^2 exceeds an
/// int, or if radius <= 0.
Mesh icosphere(int frequency, double radius);

/// Triangles of the icosphere of `frequency` n: 20 n^2.
constexpr long long triangle_count(int frequency) {
  return 20LL * frequency * frequency;
}
/// Vertices of the icosphere of `frequency` n: 10 n^2 + 2.
constexpr long long vertex_count(int frequency) {
  return 10LL * frequency * frequency + 2;
}
/// Mean length of the edges of a fine icosphere: 1.2085 radius/n. Of icosphere(n, radius) it is 4%
/// too long at n = 2, 2% at 3, and 0.2% at 8.
constexpr double icosphere_edge(double radius, int frequency) {
  return 1.2085 * radius / frequency;
}

/// Mean length of the edges of a closed mesh.
double mean_edge(const Mesh& mesh);

/// Mean length of the edges of icosphere(frequency, radius), without making it: to 1e-9 up to a
/// frequency of 32, to 2e-6 beyond. Throws std::invalid_argument if either is not positive.
double icosphere_mean_edge(int frequency, double radius);

/// The frequency n of the icosphere of `radius` whose mean edge is nearest to `edge` (at least 2).
/// Throws std::invalid_argument if either is not positive.
int frequency_for_edge(double radius, double edge);

/// Enclosed volume, by the divergence theorem: sum x0 . (x1 x x2)/6.
double volume(const Mesh& mesh);
/// Surface area.
double area(const Mesh& mesh);
/// Area of each vertex: a third of that of the triangles it belongs to. Sums to area().
std::vector<double> vertex_areas(const Mesh& mesh);

/// Unit normal of each vertex of a closed surface, outwards: the mean of its triangles', weighted
/// with their areas. `positions` hold 3 numbers a vertex.
std::vector<Eigen::Vector3d> vertex_normals(std::span<const double> positions,
                                            std::span<const std::array<int, 3>> triangles);
/// The vertices of a closed surface moved outwards by `distance`, each along its normal.
std::vector<double> offset(std::span<const double> positions,
                           std::span<const std::array<int, 3>> triangles, double distance);

/// Applies x -> rotation x + centre to every vertex.
void place(Mesh& mesh, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& centre);

}  // namespace ductile::surface
