// Hand-written bodies of each kind that the coupling serves.
#pragma once

#include <functional>
#include <stdexcept>
#include <vector>

#include "ductile/coupling/body.hpp"

namespace ductile::test {

/// Markers that exert what `law` says, given their positions: an explicit membrane's place-holder.
class Explicit final : public coupling::Body {
 public:
  using Law = std::function<void(std::span<const double> x, std::span<double> force)>;
  Explicit(std::vector<double> start, Law law) : x(std::move(start)), law_(std::move(law)) {
    velocity.resize(x.size());
  }
  [[nodiscard]] std::size_t marker_count() const override { return x.size() / 3; }
  [[nodiscard]] std::span<const double> positions() const override { return x; }
  [[nodiscard]] int corrections() const override { return 0; }
  void predict_force(std::span<double> force) override {
    if (law_) law_(x, force);
  }
  void correct_force(std::span<const double>, const coupling::Response&,
                     std::span<double>) override {
    throw std::logic_error("an explicit body takes no corrections");
  }
  void advance(std::span<const double> u) override {
    velocity.assign(u.begin(), u.end());
    for (std::size_t n = 0; n < x.size(); ++n) x[n] += u[n];
  }

  std::vector<double> x;
  std::vector<double> velocity;

 private:
  Law law_;
};

/// Multi-direct forcing with fixed markers: each correction pushes against the remaining velocity.
class Held final : public coupling::Body {
 public:
  Held(std::vector<double> start, int corrections, double gain)
      : x(std::move(start)), corrections_(corrections), gain_(gain) {}
  [[nodiscard]] std::size_t marker_count() const override { return x.size() / 3; }
  [[nodiscard]] std::span<const double> positions() const override { return x; }
  [[nodiscard]] int corrections() const override { return corrections_; }
  void predict_force(std::span<double>) override {}
  void correct_force(std::span<const double> u, const coupling::Response&,
                     std::span<double> increment) override {
    for (std::size_t n = 0; n < x.size(); ++n) increment[n] = -gain_ * u[n];
  }
  void advance(std::span<const double> u) override { velocity.assign(u.begin(), u.end()); }

  std::vector<double> x;
  std::vector<double> velocity;

 private:
  int corrections_;
  double gain_;
};

/// One marker on a spring of stiffness k to `anchor`, advanced by backward Euler: it solves for the
/// force that its end-of-step position will exert. Along each axis the response of a single marker
/// is one number.
class ImplicitSpring final : public coupling::Body {
 public:
  ImplicitSpring(std::vector<double> start, std::vector<double> anchor, double k)
      : x(std::move(start)), anchor_(std::move(anchor)), k_(k) {}
  [[nodiscard]] std::size_t marker_count() const override { return 1; }
  [[nodiscard]] std::span<const double> positions() const override { return x; }
  [[nodiscard]] int corrections() const override { return 1; }
  void predict_force(std::span<double>) override {}
  void correct_force(std::span<const double> u, const coupling::Response& response,
                     std::span<double> force) override {
    const std::vector<double> unit = {1, 1, 1};
    std::vector<double> mobility(3);
    response.apply(unit, mobility);
    // F = -k (x + u + mobility F - anchor)
    for (std::size_t n = 0; n < 3; ++n) {
      force[n] = -k_ * (x[n] + u[n] - anchor_[n]) / (1 + k_ * mobility[n]);
    }
  }
  void advance(std::span<const double> u) override {
    for (std::size_t n = 0; n < 3; ++n) x[n] += u[n];
  }

  std::vector<double> x;

 private:
  std::vector<double> anchor_;
  double k_;
};

}  // namespace ductile::test
