// Capsules and rigid bodies as the coupler sees them. The membrane and rigid libraries know nothing
// of the coupling, nor of each other: here they meet.
#pragma once

#include <span>
#include <vector>

#include "ductile/coupling/body.hpp"
#include "ductile/membrane/capsule.hpp"
#include "ductile/rigid/body.hpp"

namespace ductile::suspension {

/// A capsule in the fluid; it must outlive this.
class CapsuleMarkers final : public coupling::Body {
 public:
  explicit CapsuleMarkers(membrane::Capsule& capsule) : capsule_(capsule) {}
  [[nodiscard]] std::size_t marker_count() const override {
    return static_cast<std::size_t>(capsule_.vertex_count());
  }
  [[nodiscard]] std::span<const double> positions() const override { return capsule_.positions(); }
  [[nodiscard]] int corrections() const override { return capsule_.corrections(); }
  void predict_force(std::span<double> force) override {
    translated([&] { capsule_.predict_force(force); });
  }
  void correct_force(std::span<const double> velocity, const coupling::Response& response,
                     std::span<double> increment) override {
    translated([&] {
      capsule_.correct_force(
          velocity,
          [&](std::span<const double> force, std::span<double> answer) {
            response.apply(force, answer);
          },
          increment);
    });
  }
  void advance(std::span<const double> velocity) override {
    translated([&] { capsule_.advance(velocity); });
  }

 private:
  template <class F>
  static void translated(const F& f) {
    try {
      f();
    } catch (const membrane::VertexFailure& error) {
      throw coupling::MarkerError(static_cast<std::size_t>(error.vertex()), error.what());
    }
  }

  membrane::Capsule& capsule_;
};

/// A rigid body in the fluid; it must outlive this.
class RigidMarkers final : public coupling::Body {
 public:
  explicit RigidMarkers(rigid::Body& body) : body_(body), velocity_(3 * body.marker_count()) {}
  [[nodiscard]] std::size_t marker_count() const override { return body_.marker_count(); }
  [[nodiscard]] std::span<const double> positions() const override { return body_.positions(); }
  [[nodiscard]] int corrections() const override { return body_.corrections(); }
  void predict_force(std::span<double> force) override { body_.predict_force(force); }
  void correct_force(std::span<const double> velocity, const coupling::Response& /*response*/,
                     std::span<double> increment) override {
    body_.correct_force(velocity, increment);
  }
  void advance(std::span<const double> velocity) override {
    velocity_.assign(velocity.begin(), velocity.end());
    try {
      body_.advance(velocity);
    } catch (const rigid::MotionFailure& error) {
      throw coupling::MarkerError(error.marker(), error.what());
    }
  }
  /// The fluid's velocity at the markers in the latest step; before the first 0, unless set.
  [[nodiscard]] std::span<const double> velocity() const { return velocity_; }
  [[nodiscard]] std::span<double> velocity() { return velocity_; }

 private:
  rigid::Body& body_;
  std::vector<double> velocity_;
};

}  // namespace ductile::suspension
