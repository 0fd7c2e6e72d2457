// A rigid body that a fluid carries, by multi-direct forcing.
//
// The body is a set of markers on its surface. Fluid fills it inside and out; the markers' force F
// on the fluid makes that surface move rigidly. In each time step, from t^n to t^(n+1) = t^n + 1,
// the fluid reports the marker velocities u with the force so far, and the body answers with
//
//     dF_m = 2 rho kappa A_m (U + omega x r_m - u_m)                                           (1)
//
// a few times over (Inamuro 2012, Fluid Dyn. Res. 44, 024001). A_m is the marker's area, rho = 1
// the fluid's density; the 2 is there because u holds half of the force (Guo). The fluid answers dF
// with du = (1/2 rho) S S^T dF, S interpolation and S^T spreading, so that (1) is Richardson's
// iteration for no slip: a slip mode of eigenvalue lambda of S S^T A shrinks by 1 - kappa lambda
// each time.
//
// What the kernel smooths it also misses of the fluid's answer: of a force along the surface b f_t,
// f_t being that force per area. Surface::missed is b, and with it (1) becomes
//
//     dF_m = 2 kappa A_m T_m (U + omega x r_m - u_m - b P_m F_m/A_m)
//     T_m  = 1 - P_m + P_m/(1 + 2 kappa b)
//
// with P_m the projection onto the surface: no slip of the fluid that there would be, the part of
// dF in it taken at its end.
//
// The force of the step before may serve as a first guess, Options::memory: in a flow that hardly
// changes within a step much of the slip is then gone before the first answer.
//
// U and omega are not known beforehand. Inside each answer (1) they are those for which
//
//     (M - M_f) [U - U_prev - g] = - sum_m F_m + F_film                                        (2)
//     L - L_prev                 = - sum_m r_m x F_m + T_film,     L = (I - I_f) omega         (3)
//
// hold at that very moment, dF included: a 6 x 6 linear system. F_film and T_film are those of
// films to other bodies, if there are any (lubrication.hpp); the markers hand them on to the fluid.
// These are the paper's (12)-(14) with Feng's force M_f (U - U_prev) for the fluid inside, but with
// that force and the velocities at one time level, so that nothing is ever divided by M - M_f: at
// equal densities (2) and (3) say that force and torque vanish but for films, and U and omega are
// the means of the fluid's motion over the surface. L changes with the orientation, which is the
// gyroscopic term. A uniform driving force of the fluid acts on the fluid inside too, and is not
// added again.
//
// M_f and I_f take the fluid inside to move with the body. In a translation it does, by its
// pressure; a change of spin it learns by viscosity, in about a^2/(20 nu). Inner shells of markers
// (lined()) make it follow within a few steps.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "ductile/surface/mesh.hpp"
#include "ductile/surface/shape.hpp"

namespace ductile::rigid {

/// Markers on a body's surface (and inside it, see lined()), in the body frame: axes fixed to the
/// body, origin at its centre of mass.
struct Surface {
  std::vector<Eigen::Vector3d> markers;
  std::vector<double> areas;  ///< of each marker
  /// Unit normals of the markers on the surface, which come first, if anything is `missed` there;
  /// else empty.
  std::vector<Eigen::Vector3d> normals;
  /// Velocity that the fluid has along the surface there, and its average at the marker has not,
  /// per force per area along it: b of (1).
  double missed = 0;
};

/// A homogeneous solid.
struct Solid {
  double volume = 0;
  /// Moments of inertia about the centre of mass per unit density, body frame:
  /// the integral of |r|^2 1 - r r^T over the volume.
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
};

/// What fills a shape. Its markers may well lie slightly inside the shape's surface (an offset of
/// Shape::mesh()), to make up for the width of the kernel.
Solid solid_of(const surface::Shape& shape);
/// A marker at each vertex of a closed mesh, with the vertex's area and normal.
Surface markers_of(const surface::Mesh& mesh, double missed = 0);

/// What moves a body.
enum class Motion {
  free,        ///< the fluid and gravity
  prescribed,  ///< velocities given from outside; the body reports the force that it takes
};

/// All in lattice units (dx = dt = rho = 1, rho the fluid's density).
struct Options {
  Motion motion = Motion::free;
  double density_ratio = 1;  ///< solid to fluid; not used by a prescribed motion
  /// Acceleration. What acts on a free body is (M - M_f) g: the fluid is meant to feel no gravity,
  /// its hydrostatic pressure being the buoyancy.
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  /// Answers (1) in a time step. With kappa = 2 a smooth slip falls to 8e-4 in five, which is below
  /// what the kernel cannot resolve anyway (about 1e-2 of the velocity, at single markers).
  int corrections = 5;
  /// kappa. With Peskin's 4-point kernel the largest eigenvalue of S S^T A is that of smooth modes,
  /// 0.38 (sum phi^2 = 3/8; a = 4 to 18, marker spacings 0.8 and 1.2), so that kappa < 5.2 would
  /// converge, 2.6 fastest. Two surfaces that touch have twice that eigenvalue and need
  /// kappa < 2.6; 2 serves both.
  double relaxation = 2;
  /// m: predict_force() gives m times each marker's force of the step before, turned with the body.
  /// With P = (1 - kappa lambda)^corrections a steady slip ends at P (1 - m)/(1 - m P) of what it
  /// is without force. Two corrections with m = 0.9 do what five do without. Much above that,
  /// forces that the kernel filters (lambda near 0) pile up as the lattice passes by under them,
  /// and spoil the motion: 0.95 at most. What a step does not know of, such as a second surface
  /// within the kernel's reach, makes P negative for an odd number of corrections: take an even
  /// one.
  double memory = 0;
};

/// Markers that make a shape solid: on its surface, those of mesh(frequency, -retraction) in their
/// order, and then on shells inside, copies of the surface shrunk towards the centre of mass, so
/// that the fluid there moves with the body. The first shell is 1.5 lattice spacings inside of the
/// surface, each other 3 inside of the one before, down to a radius of 2; if the first were at 3
/// too, the fluid next to the surface would slip. Edges are one and a half times those of the
/// surface. Areas are the shell's, for the first half of it, which lies within reach of the
/// surface's kernel: the largest eigenvalue of S S^T A is then 0.42, and at most 0.82 where two
/// such bodies touch (flat ones), which need a relaxation below 2.4 (see Options::relaxation).
/// Throws std::invalid_argument as Shape::mesh().
Surface lined(const surface::Shape& shape, int frequency, double retraction, double missed = 0);
/// How many markers lined() makes, without making them; of a shape that is no sphere by its reach,
/// which its vertices fall short of by a little.
long long lined_marker_count(const surface::Shape& shape, int frequency, double retraction);

/// The least density ratio at which a free body is stable with this surface and relaxation, see
/// Body; negative if that is any. In half of a fluid, on a mirror plane, there is `no_answer` to
/// rigid motion that is not symmetric: a body across the plane must be a little heavier there, or
/// what round-off gives it of such motion grows.
double least_density_ratio(const Surface& surface, const Solid& solid, double relaxation,
                           bool no_answer = false);

/// A body's state between time steps; with the same surface, solid and options it determines all
/// that follows, to the last bit.
struct State {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< centre of mass; never wrapped
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< that moved it here in the last step
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< body frame to space frame
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< space frame; that turned it here
  /// Force of each marker on the fluid in the last step, body frame. Kept with a memory alone;
  /// given empty: 0.
  std::vector<Eigen::Vector3d> forces;
};

/// Takes a part of an object's state: its name, unique within the object, and its numbers.
using StateWriter = std::function<void(std::string_view name, std::span<const double> numbers)>;
/// Fills in what a StateWriter took under that name, of the same size.
using StateReader = std::function<void(std::string_view name, std::span<double> numbers)>;

/// Velocity that the markers, those inside too, have and the fluid does not: what (1) has in
/// brackets.
struct Slip {
  double max = 0;
  double rms = 0;  ///< weighted with the areas
};

/// A body left the range in which a time step means anything. It is as it was before that step.
class MotionFailure : public std::runtime_error {
 public:
  MotionFailure(const std::string& reason, std::size_t marker)
      : std::runtime_error(reason), marker_(marker) {}
  /// The marker that moved furthest, or not to a finite place.
  [[nodiscard]] std::size_t marker() const { return marker_; }

 private:
  std::size_t marker_;
};

/// A rigid body. Each time step is predict_force(), corrections() times correct_force(), advance(),
/// in this order. All spans hold 3 marker_count() numbers, x y z of each marker in turn, space
/// frame, lattice units; the wrong size throws std::invalid_argument. Nothing is collective.
class Body {
 public:
  /// Throws std::invalid_argument for a surface, solid, options or state out of bounds, and for a
  /// free body too light for its size. Where M < M_f the body pushes the fluid the wrong way, which
  /// must not outweigh the fluid that follows the markers within a step: a layer about as wide as
  /// the kernel. For a lump of fluid that answers with the eigenvalue lambda, (2) is stable if
  /// M_f - M < A/lambda = 2.6 A; with the lattice Boltzmann fluid it was at 2.5 A (a = 12 to 24,
  /// tau = 0.52 to 1), and not at 3 A. So 2.5 A is the bound, for translation, and alike for every
  /// rigid motion. For a sphere it is density_ratio >= 1 - 7.5/a: none up to a = 7.5, 0.5 at a =
  /// 15. A relaxation under 1.7 lowers it, as then the corrections do not converge. Shells count
  /// with their areas; with those of lined() spheres of a = 12 to 24 are stable down to 0.21 at
  /// least.
  Body(Surface surface, const Solid& solid, const Options& options, const State& state);

  /// n, constant.
  [[nodiscard]] std::size_t marker_count() const { return surface_.markers.size(); }
  /// Markers, from position and orientation afresh each step: the shape does not drift. Valid until
  /// advance() or load().
  [[nodiscard]] std::span<const double> positions() const { return positions_; }
  /// Options::corrections.
  [[nodiscard]] int corrections() const { return options_.corrections; }

  /// force <- what Options::memory keeps; the rest takes the fluid's velocity to know. Begins a
  /// step.
  void predict_force(std::span<double> force);
  /// increment <- (1), given the fluid's velocity u at the markers with the force so far.
  void correct_force(std::span<const double> velocity, std::span<double> increment);
  /// Moves the body by one step with the U and omega of the last correction: x + U, and the
  /// rotation by |omega| about omega. `velocity`, the fluid's at the markers with the whole force,
  /// only tells the slip. Throws MotionFailure if a marker would move by more than half a lattice
  /// spacing or to no finite place; the state is then that before the step.
  void advance(std::span<const double> velocity);

  /// What the fluid exerts on the body in the next step, force and torque about its centre of mass,
  /// other than by the markers: that of films too thin for the lattice (lubrication.hpp). Until
  /// advance() or load(); then there is none. Throws std::invalid_argument if it is not finite.
  void set_film_force(const Eigen::Vector3d& force, const Eigen::Vector3d& torque);

  /// Sets the motion of a prescribed body from the next step on. Throws std::logic_error if free.
  void prescribe(const Eigen::Vector3d& velocity, const Eigen::Vector3d& angular_velocity);

  [[nodiscard]] const State& state() const { return state_; }
  /// Writes state(), what prescribe() has said, and what the accessors below tell of the last step;
  /// between two steps.
  void save(const StateWriter& write) const;
  /// Takes over what save() of a body of the same surface, solid and options wrote, and goes on to
  /// the last bit as that one would have. Passes on what `read` throws, and throws
  /// std::invalid_argument for a state out of bounds; the body is then as it was.
  void load(const StateReader& read);
  /// Force of the surrounding fluid on the solid in the last step, without buoyancy: minus the
  /// markers' force, plus Feng's M_f (U - U_prev) and the films'.
  [[nodiscard]] const Eigen::Vector3d& hydrodynamic_force() const { return hydrodynamic_force_; }
  /// Torque about the centre of mass, alike.
  [[nodiscard]] const Eigen::Vector3d& hydrodynamic_torque() const { return hydrodynamic_torque_; }
  /// Slip that the last step left.
  [[nodiscard]] const Slip& slip() const { return slip_; }

 private:
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  using Matrix6d = Eigen::Matrix<double, 6, 6>;

  template <class Self, class Io>
  static void transfer_parts(Self& self, const Io& io);

  void place_markers();
  void check_size(std::span<const double> values) const;
  // A body-frame tensor applied to a space-frame vector.
  [[nodiscard]] Eigen::Vector3d apply_turned(const Eigen::Matrix3d& tensor,
                                             const Eigen::Vector3d& vector) const;
  // Per unit density, at t^(n-1).
  [[nodiscard]] Eigen::Vector3d angular_momentum_before() const;
  // Adds to the force of the step under way.
  void add_force(std::size_t marker, const Eigen::Vector3d& force);
  // The fluid's velocity at a marker, what the kernel misses of it included.
  [[nodiscard]] Eigen::Vector3d fluid_at(std::span<const double> velocity,
                                         std::size_t marker) const;
  // 2 kappa A_m T_m v
  [[nodiscard]] Eigen::Vector3d answer(std::size_t marker, const Eigen::Vector3d& velocity) const;

  Surface surface_;
  Solid solid_;
  Options options_;
  State state_;
  // Of (2) and (3) with (1), body frame; of a free body.
  Eigen::LLT<Matrix6d> balance_{Matrix6d::Identity()};

  std::vector<Eigen::Vector3d> arms_;     // r_m, space frame
  std::vector<Eigen::Vector3d> normals_;  // space frame, of those that have one
  std::vector<double> positions_;

  // The step under way: U and omega, and the markers' forces on the fluid with total and torque.
  Eigen::Vector3d velocity_, angular_velocity_;
  std::vector<Eigen::Vector3d> forces_;
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero(), torque_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d film_force_ = Eigen::Vector3d::Zero(), film_torque_ = Eigen::Vector3d::Zero();

  Eigen::Vector3d hydrodynamic_force_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d hydrodynamic_torque_ = Eigen::Vector3d::Zero();
  Slip slip_;
};

}  // namespace ductile::rigid
