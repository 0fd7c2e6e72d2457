#include "force.hpp"

#include <algorithm>

namespace ductile::membrane {
namespace {

// Filled up to a multiple of four with copies of the last.
template <class T>
void fill_up(std::vector<T>& numbers) {
  while (numbers.size() % 4 != 0) numbers.push_back(numbers.back());
}

}  // namespace

const ForceKernel& force_kernel([[maybe_unused]] InstructionSet set) {
#ifdef DUCTILE_X86
  if (set == InstructionSet::avx512) return avx512::force_kernel();
  if (set == InstructionSet::avx2) return avx2::force_kernel();
#endif
  return baseline::force_kernel();
}

Force::Force(std::span<const Triangle> triangles, std::span<const Edge> edges, int vertices,
             InstructionSet set)
    : kernel_(&force_kernel(set)),
      triangles_(triangles.size()),
      edges_(edges.size()),
      position_(static_cast<std::size_t>(vertices)),
      force_(static_cast<std::size_t>(vertices)) {
  for (const Edge& edge : edges) {
    left_.push_back(edge.left);
    right_.push_back(edge.right);
    tail_.push_back(edge.tail);
    head_.push_back(edge.head);
    cos0_.push_back(edge.cos0);
    sin0_.push_back(edge.sin0);
  }
  for (std::vector<int>* numbers : {&left_, &right_, &tail_, &head_}) fill_up(*numbers);
  for (std::vector<double>* numbers : {&cos0_, &sin0_}) fill_up(*numbers);
  const auto rim = static_cast<int>(left_.size());
  moment_.resize(left_.size() + 1, 0.0);
  for (const Triangle& triangle : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      vertex_[k].push_back(triangle.vertex[k]);
      const int edge = triangle.edge[k];
      edge_[k].push_back(edge == static_cast<int>(edges_) ? rim : edge);
    }
    a11_.push_back(triangle.a11);
    a12_.push_back(triangle.a12);
    a22_.push_back(triangle.a22);
    inverse_det_.push_back(triangle.inverse_det);
    area_.push_back(triangle.area);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    fill_up(vertex_[k]);
    fill_up(edge_[k]);
  }
  for (std::vector<double>* numbers : {&a11_, &a12_, &a22_, &inverse_det_, &area_})
    fill_up(*numbers);
  normal_.resize(a11_.size());
}

ForceElements Force::elements() const {
  return {triangles_,
          {vertex_[0].data(), vertex_[1].data(), vertex_[2].data()},
          {edge_[0].data(), edge_[1].data(), edge_[2].data()},
          a11_.data(),
          a12_.data(),
          a22_.data(),
          inverse_det_.data(),
          area_.data(),
          edges_,
          left_.data(),
          right_.data(),
          tail_.data(),
          head_.data(),
          cos0_.data(),
          sin0_.data()};
}

double Force::start(const double* positions) {
  for (std::size_t v = 0; v < position_.size(); ++v)
    std::copy_n(positions + 3 * v, 3, position_[v].of);
  return kernel_->normals(elements(), position_.data(), normal_.data()) / 6;
}

void Force::finish(const ForceModuli& moduli, double pressure, double* force) {
  kernel_->moments(elements(), moduli.bending, position_.data(), normal_.data(), moment_.data());
  std::fill(force_.begin(), force_.end(), Four{});
  kernel_->forces(elements(), moduli, pressure, position_.data(), normal_.data(), moment_.data(),
                  force_.data());
  for (std::size_t v = 0; v < force_.size(); ++v) std::copy_n(force_[v].of, 3, force + 3 * v);
}

}  // namespace ductile::membrane
