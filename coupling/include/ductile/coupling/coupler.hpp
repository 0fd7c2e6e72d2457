// The immersed boundary: bodies in a fluid, and the one time step of both.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "ductile/coupling/body.hpp"
#include "ductile/coupling/profile.hpp"
#include "ductile/fluid/fluid.hpp"

namespace ductile::coupling {

/// A body on the rank that owns it. Ids number all bodies of all ranks 0 .. total - 1.
struct Member {
  int id;
  Body* body;
};

/// A body could not be advanced. Thrown on every rank, with the same body, step and reason. The
/// step is not complete: fluid and bodies may have taken it or not.
class BodyFailure : public std::runtime_error {
 public:
  enum class Cause {
    body,     ///< what the body itself throws, or a marker at no finite place
    boundary  ///< a marker too close to a boundary of the fluid for the kernel
  };
  BodyFailure(int body, Cause cause, std::optional<std::size_t> marker, std::int64_t step,
              const std::string& reason);
  [[nodiscard]] int body() const { return body_; }
  [[nodiscard]] Cause cause() const { return cause_; }
  /// The marker at fault, where it was one.
  [[nodiscard]] std::optional<std::size_t> marker() const { return marker_; }
  [[nodiscard]] std::int64_t step() const { return step_; }
  [[nodiscard]] const std::string& reason() const { return reason_; }

 private:
  int body_;
  Cause cause_;
  std::optional<std::size_t> marker_;
  std::int64_t step_;
  std::string reason_;
};

/// Couples bodies to a fluid by Peskin's immersed boundary method, eqs. (15)-(17), and advances
/// both. It keeps no physical state: boxes, routes and messages only. Results do not depend
/// on the number of ranks, to the last bit: forces are spread in the order of bodies and markers,
/// and a marker's velocity is summed plane by plane, in the planes' order.
class Coupler {
 public:
  /// Collective. `bodies` are this rank's own, `total` is the number of all ranks' together; the
  /// fluid and the bodies outlive the coupler. Positions, velocities and forces of bodies are those
  /// in the frame at rest (fluid::LatticeMotion). With a mirror plane a body that
  /// has markers on both sides is its own image, and of its forces the symmetric part acts; any
  /// other has an image as its twin. Bodies that are not symmetric may not cross the plane. Throws
  /// std::invalid_argument, on every rank, if the ids are not 0 .. total - 1, each once, or a body
  /// has no markers.
  Coupler(fluid::Fluid& fluid, std::vector<Member> bodies, int total);
  ~Coupler();
  Coupler(const Coupler&) = delete;
  Coupler& operator=(const Coupler&) = delete;

  /// One time step of fluid and bodies, as body.hpp states it. Collective. Throws BodyFailure if a
  /// body fails, or has a marker whose stencil leaves the fluid or wraps round x or y.
  void step();
  /// Says that bodies' states have been replaced from outside, as by loading them: the next step
  /// lays boxes and routes anew, as that of a new coupler would. Called by all ranks if by any;
  /// sends nothing.
  void bodies_replaced();

  /// Where this rank's time has gone, and how many bytes it has sent in steps, since construction
  /// or since reset_profile(). Always kept: a step reads the clock twelve times, and six
  /// more for each round of corrections. A step that throws counts until then.
  [[nodiscard]] const Profile& profile() const;
  void reset_profile();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ductile::coupling
