// The coupling interface: all that a fluid and a body know of each other.
//
// A body is a set of markers on its surface. In each time step, from t to t + 1 (lattice units,
// dx = dt = rho0 = 1), the two exchange marker velocities u and marker forces F, nothing else:
//
//   1.  F  = body.predict_force()                    what the body knows without asking the fluid
//   2.  as often as body.corrections() says:
//           u  = S u0 + S S^T F/(2 rho)              the fluid's velocity with all force so far
//           F += body.correct_force(u, response)
//   3.  the fluid collides and streams with the force density S^T F
//   4.  u  = S u0 + S S^T F/(2 rho)                  of the step's start, which the fluid has left
//       body.advance(u)                              markers move to x^(n+1)
//
// S interpolates at the markers' positions x^n with Peskin's 4-point kernel, S^T spreads; u0 is the
// fluid's velocity with the uniform driving force, rho its density. The factor 1/2 is that of Guo's
// forcing: the velocity at t holds half of the force of the step that starts at t, so that marker
// and fluid velocity are one and the same (no slip) for whatever F was chosen.
//
// Three kinds of body fit this one shape:
//   - its force follows from its positions (explicit membrane): predict_force(), no corrections;
//   - it solves for its end-of-step positions (implicit membrane): corrections, in which
//     it asks `response` how the velocity answers to a force it has not yet given;
//   - its force is whatever makes its surface move rigidly (multi-direct forcing): several
//     corrections, each adding the force that the remaining slip calls for.
//
// Bodies advance side by side: every F of a round is spread before any u of the next is taken, so
// that bodies in near contact feel each other within the step.
#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>

namespace ductile::coupling {

/// The fluid's instantaneous answer to forces at a body's own markers, with those markers fixed at
/// x^n: the linear map F -> S S^T F/(2 rho). Symmetric and positive semi-definite; local to the
/// rank that owns the body, so a solver may call it as often as it likes.
class Response {
 public:
  virtual ~Response() = default;
  /// velocity <- S S^T force/(2 rho); both 3n, interlaced x y z. Not collective.
  virtual void apply(std::span<const double> force, std::span<double> velocity) const = 0;
};

/// What a body throws that cannot go on because of one of its markers. Any other exception of a
/// body is reported as well, without a marker.
class MarkerError : public std::runtime_error {
 public:
  MarkerError(std::size_t marker, const std::string& reason)
      : std::runtime_error(reason), marker_(marker) {}
  [[nodiscard]] std::size_t marker() const { return marker_; }

 private:
  std::size_t marker_;
};

/// A body immersed in the fluid. It owns its markers; the coupler keeps no physical state. All
/// arrays hold 3n numbers, x y z of each marker in turn, in lattice units; z runs on without
/// wrapping in a periodic channel. Only the rank that owns a body has it and calls it; no call is
/// collective. An exception thrown here ends the step on every rank.
class Body {
 public:
  Body() = default;
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;
  virtual ~Body() = default;

  /// n, constant; does not throw.
  [[nodiscard]] virtual std::size_t marker_count() const = 0;
  /// x^n; valid until advance().
  [[nodiscard]] virtual std::span<const double> positions() const = 0;
  /// How many marker velocities the body needs before its force is final; constant, does not throw.
  [[nodiscard]] virtual int corrections() const = 0;
  /// force <- what the body exerts on the fluid as far as it knows or guesses without asking it.
  virtual void predict_force(std::span<double> force) = 0;
  /// increment <- what to add to the force, given the velocity that the force so far causes.
  /// Called corrections() times.
  virtual void correct_force(std::span<const double> velocity, const Response& response,
                             std::span<double> increment) = 0;
  /// Moves the markers by one time step, given their velocity with the whole force in.
  virtual void advance(std::span<const double> velocity) = 0;
};

}  // namespace ductile::coupling
