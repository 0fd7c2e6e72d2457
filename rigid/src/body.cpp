#include "ductile/rigid/body.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "reject.hpp"

namespace ductile::rigid {

namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Largest eigenvalue of S S^T A for Peskin's 4-point kernel on a smooth surface.
constexpr double largest_response = 0.381;
// M_f - M per area that the fluid next to the surface holds, see Body::Body.
constexpr double least_fluid = 2.5;
// Shells at this distance hardly feel each other through the kernel.
constexpr double shell_spacing = 3;
// The first is nearer to the surface, so that it keeps hold of all the fluid that the surface's own
// kernel averages over; with its whole area the corrections of two bodies that touch would not
// converge.
constexpr double first_depth = 1.5;
constexpr double first_weight = 0.5;
// What is left inside is less than the kernel's reach.
constexpr double least_shell = 2;
// Edges of a shell over those of the surface: nothing is to be seen from outside.
constexpr double shell_coarseness = 1.5;
// A step that moves a marker further is at 0.87 of the speed of sound: long past the lattice
// Boltzmann method's range.
constexpr double largest_displacement = 0.5;
// A sphere at 24 nodes across migrates 0.1% less with 0.95, 1% with 0.98, and 11% with 1.
constexpr double largest_memory = 0.95;

Matrix3d cross_matrix(const Vector3d& r) {
  Matrix3d m;
  m << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  return m;
}

// The rotation by |omega| about omega.
Quaterniond exponential(const Vector3d& omega) {
  const double half = 0.5 * omega.norm();
  const double sinc = half > 1e-4 ? std::sin(half) / half : 1 - half * half / 6;
  Quaterniond q;
  q.w() = std::cos(half);
  q.vec() = 0.5 * sinc * omega;
  return q;
}

Vector3d at(std::span<const double> values, std::size_t marker) {
  return Eigen::Map<const Vector3d>(values.data() + 3 * marker);
}

void store(const Vector3d& value, std::span<double> values, std::size_t marker) {
  Eigen::Map<Vector3d>(values.data() + 3 * marker) = value;
}

void check_surface(const Surface& surface) {
  const std::size_t n = surface.markers.size();
  if (surface.areas.size() != n)
    reject(n, " markers have ", surface.areas.size(), " areas: give one for each");
  for (std::size_t m = 0; m < n; ++m) {
    if (!surface.markers[m].allFinite()) reject("marker ", m, " has no finite position");
    if (!(surface.areas[m] > 0) || !std::isfinite(surface.areas[m]))
      reject("area of marker ", m, " is ", surface.areas[m], ": it must be positive");
  }
  if (!(surface.missed >= 0) || !std::isfinite(surface.missed))
    reject("missed = ", surface.missed, ": it must be finite and not negative");
  if (surface.normals.size() > n || (surface.missed > 0 && surface.normals.empty())) {
    reject(n, " markers have ", surface.normals.size(),
           " normals: give one for each on the surface");
  }
  for (const Vector3d& normal : surface.normals)
    if (!(std::abs(normal.norm() - 1) < 1e-9)) reject("normals must be of unit length");
}

void check_solid(const Solid& solid) {
  if (!(solid.volume > 0) || !std::isfinite(solid.volume))
    reject("volume = ", solid.volume, ": it must be positive");
  const Matrix3d& inertia = solid.inertia;
  if (!inertia.allFinite() || !inertia.isApprox(inertia.transpose(), 1e-12) ||
      Eigen::LLT<Matrix3d>(inertia).info() != Eigen::Success)
    reject("inertia must be a symmetric, positive definite 3 x 3 tensor");
}

void check_options(const Options& options) {
  if (!(options.density_ratio > 0) || !std::isfinite(options.density_ratio))
    reject("density_ratio = ", options.density_ratio, ": it must be positive");
  if (!options.gravity.allFinite()) reject("gravity must be finite");
  if (options.corrections < 1)
    reject("corrections = ", options.corrections, ": a body needs at least 1 (default 5)");
  const double bound = 1 / largest_response;
  if (!(options.relaxation > 0 && options.relaxation <= bound)) {
    reject("relaxation = ", options.relaxation, ": choose it above 0 and up to ", bound,
           ", where two surfaces that touch still converge (default 2)");
  }
  if (!(options.memory >= 0 && options.memory <= largest_memory))
    reject("memory = ", options.memory, ": choose it from 0 to ", largest_memory);
}

void check_state(const State& state, std::size_t markers) {
  if (!state.position.allFinite() || !state.velocity.allFinite() ||
      !state.angular_velocity.allFinite())
    reject("position and velocities must be finite");
  if (!(std::abs(state.orientation.norm() - 1) < 1e-9))
    reject("orientation has norm ", state.orientation.norm(), ": normalise the quaternion");
  if (!state.forces.empty() && state.forces.size() != markers) {
    reject(markers, " markers have ", state.forces.size(),
           " forces of the step before: give one for each, or none");
  }
  for (const Vector3d& force : state.forces)
    if (!force.allFinite()) reject("forces of the step before must be finite");
}

// T_m v of (1), n being the normal of a marker on the surface.
Vector3d lessened(const Vector3d& v, const Vector3d& n, double missed, double kappa) {
  const Vector3d normal = n.dot(v) * n;
  return normal + (v - normal) / (1 + 2 * kappa * missed);
}

// sum A J^T T J with J = [1, -r x], so that U + omega x r = J (U, omega).
Matrix6d area_tensor(const Surface& surface, double kappa) {
  Matrix6d tensor = Matrix6d::Zero();
  for (std::size_t m = 0; m < surface.markers.size(); ++m) {
    Eigen::Matrix<double, 3, 6> motion;
    motion << Matrix3d::Identity(), -cross_matrix(surface.markers[m]);
    Eigen::Matrix<double, 3, 6> answer = motion;
    if (m < surface.normals.size()) {
      for (int k = 0; k < 6; ++k)
        answer.col(k) = lessened(motion.col(k), surface.normals[m], surface.missed, kappa);
    }
    tensor += surface.areas[m] * motion.transpose() * answer;
  }
  return tensor;
}

// (M_f, I_f).
Matrix6d displaced_tensor(const Solid& solid) {
  Matrix6d tensor = Matrix6d::Zero();
  tensor.topLeftCorner<3, 3>() = solid.volume * Matrix3d::Identity();
  tensor.bottomRightCorner<3, 3>() = solid.inertia;
  return tensor;
}

}  // namespace

double least_density_ratio(const Surface& surface, const Solid& solid, double relaxation,
                           bool no_answer) {
  // Displaced fluid per area, in the rigid motion that has most of it: a/3 for a sphere.
  const double thickness =
      Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6d>(
          displaced_tensor(solid), area_tensor(surface, relaxation), Eigen::EigenvaluesOnly)
          .eigenvalues()[5];
  // A rigid mode of slip shrinks with each correction by
  //     (1 - kappa lambda) (M - M_f)/(2 kappa A + M - M_f),
  // which for M < M_f is less than 1 in magnitude if M_f - M < converging A. Without an answer
  // lambda is 0.
  const double converging =
      no_answer ? relaxation : 2 * relaxation / (1 + std::abs(1 - relaxation * largest_response));
  return 1 - std::min(converging, least_fluid) / thickness;
}

Solid solid_of(const surface::Shape& shape) {
  return {shape.volume(), shape.inertia()};
}

Surface markers_of(const surface::Mesh& mesh, double missed) {
  Surface surface{mesh.vertices, surface::vertex_areas(mesh), {}, missed};
  if (missed != 0) {
    surface.normals = surface::vertex_normals(
        {mesh.vertices.data()->data(), 3 * mesh.vertices.size()}, mesh.triangles);
  }
  return surface;
}

namespace {

struct Shell {
  double scale;   // of the surface
  double weight;  // of the areas of a mesh as large as the surface
  int frequency;
};

// Inside of a surface that reaches as far as `radius`.
std::vector<Shell> shells(double radius, int frequency) {
  std::vector<Shell> list;
  for (double depth = first_depth; radius - depth >= least_shell; depth += shell_spacing) {
    const double scale = 1 - depth / radius;
    const int coarser = static_cast<int>(std::lround(frequency * scale / shell_coarseness));
    list.push_back(
        {scale, scale * scale * (depth == first_depth ? first_weight : 1), std::max(2, coarser)});
  }
  return list;
}

}  // namespace

long long lined_marker_count(const surface::Shape& shape, int frequency, double retraction) {
  long long count = surface::vertex_count(frequency);
  for (const Shell& shell : shells(shape.reach() - retraction, frequency))
    count += surface::vertex_count(shell.frequency);
  return count;
}

Surface lined(const surface::Shape& shape, int frequency, double retraction, double missed) {
  Surface surface = markers_of(shape.mesh(frequency, -retraction), missed);
  double radius = 0;
  for (const Vector3d& r : surface.markers) radius = std::max(radius, r.norm());
  for (const Shell& shell : shells(radius, frequency)) {
    const Surface mesh = markers_of(shape.mesh(shell.frequency, -retraction));
    for (std::size_t m = 0; m < mesh.markers.size(); ++m) {
      surface.markers.emplace_back(shell.scale * mesh.markers[m]);
      surface.areas.push_back(shell.weight * mesh.areas[m]);
    }
  }
  return surface;
}

Body::Body(Surface surface, const Solid& solid, const Options& options, const State& state)
    : surface_(std::move(surface)),
      solid_(solid),
      options_(options),
      state_(state),
      velocity_(state.velocity),
      angular_velocity_(state.angular_velocity) {
  check_surface(surface_);
  check_solid(solid_);
  check_options(options_);
  check_state(state_, marker_count());

  const Matrix6d area = area_tensor(surface_, options_.relaxation);
  const Matrix6d displaced = displaced_tensor(solid_);
  const Matrix3d turning = area.bottomRightCorner<3, 3>();
  const double least_turning =
      Eigen::SelfAdjointEigenSolver<Matrix3d>(turning, Eigen::EigenvaluesOnly).eigenvalues()[0];
  if (marker_count() < 3 || !(least_turning > 1e-9 * turning.trace()))
    reject(marker_count(), " markers on a line or fewer than 3: they must span a surface");

  if (options_.motion == Motion::free) {
    const double least = least_density_ratio(surface_, solid_, options_.relaxation);
    if (!(options_.density_ratio >= least)) {
      reject("density_ratio = ", options_.density_ratio, " is below ", least,
             ", the least that is stable for a free body with this surface and relaxation ",
             options_.relaxation,
             ": choose it larger, or make the body solid by inner shells (rigid::lined)");
    }
    balance_.compute(2 * options_.relaxation * area + (options_.density_ratio - 1) * displaced);
  }
  if (options_.memory == 0) {
    state_.forces.clear();
  } else if (state_.forces.empty()) {
    state_.forces.assign(marker_count(), Vector3d::Zero());
  }
  forces_.resize(marker_count());
  arms_.resize(marker_count());
  normals_.resize(surface_.normals.size());
  positions_.resize(3 * marker_count());
  place_markers();
}

void Body::place_markers() {
  const Matrix3d rotation = state_.orientation.toRotationMatrix();
  for (std::size_t m = 0; m < marker_count(); ++m) {
    arms_[m] = rotation * surface_.markers[m];
    store(state_.position + arms_[m], positions_, m);
  }
  for (std::size_t m = 0; m < normals_.size(); ++m) normals_[m] = rotation * surface_.normals[m];
}

void Body::check_size(std::span<const double> values) const {
  if (values.size() != 3 * marker_count())
    reject("got ", values.size(), " numbers for ", marker_count(), " markers: give 3 for each");
}

Vector3d Body::apply_turned(const Matrix3d& tensor, const Vector3d& vector) const {
  return state_.orientation * (tensor * (state_.orientation.conjugate() * vector));
}

Vector3d Body::angular_momentum_before() const {
  // In the last step the body turned about omega, which the turn left where it was.
  const Vector3d& omega = state_.angular_velocity;
  return exponential(omega).conjugate() * apply_turned(solid_.inertia, omega);
}

void Body::predict_force(std::span<double> force) {
  check_size(force);
  std::fill(force.begin(), force.end(), 0.0);
  std::fill(forces_.begin(), forces_.end(), Vector3d::Zero());
  force_.setZero();
  torque_.setZero();
  for (std::size_t m = 0; m < state_.forces.size(); ++m) {
    const Vector3d guess = state_.orientation * (options_.memory * state_.forces[m]);
    store(guess, force, m);
    add_force(m, guess);
  }
}

void Body::add_force(std::size_t marker, const Vector3d& force) {
  forces_[marker] += force;
  force_ += force;
  torque_ += arms_[marker].cross(force);
}

Vector3d Body::fluid_at(std::span<const double> velocity, std::size_t marker) const {
  if (marker >= normals_.size()) return at(velocity, marker);
  const Vector3d& n = normals_[marker];
  const Vector3d& force = forces_[marker];
  return at(velocity, marker) +
         surface_.missed / surface_.areas[marker] * (force - n.dot(force) * n);
}

Vector3d Body::answer(std::size_t marker, const Vector3d& velocity) const {
  const double size = 2 * options_.relaxation * surface_.areas[marker];
  if (marker >= normals_.size()) return size * velocity;
  return size * lessened(velocity, normals_[marker], surface_.missed, options_.relaxation);
}

void Body::correct_force(std::span<const double> velocity, std::span<double> increment) {
  check_size(velocity);
  check_size(increment);

  if (options_.motion == Motion::free) {
    const double excess = options_.density_ratio - 1;
    Vector3d momentum =
        excess * solid_.volume * (state_.velocity + options_.gravity) - force_ + film_force_;
    Vector3d angular_momentum = excess * angular_momentum_before() - torque_ + film_torque_;
    for (std::size_t m = 0; m < marker_count(); ++m) {
      const Vector3d drive = answer(m, fluid_at(velocity, m));
      momentum += drive;
      angular_momentum += arms_[m].cross(drive);
    }
    const Quaterniond to_body = state_.orientation.conjugate();
    Eigen::Matrix<double, 6, 1> balance;
    balance << to_body * momentum, to_body * angular_momentum;
    balance = balance_.solve(balance);
    velocity_ = state_.orientation * balance.head<3>();
    angular_velocity_ = state_.orientation * balance.tail<3>();
  }
  for (std::size_t m = 0; m < marker_count(); ++m) {
    const Vector3d slip = velocity_ + angular_velocity_.cross(arms_[m]) - fluid_at(velocity, m);
    const Vector3d force = answer(m, slip);
    store(force, increment, m);
    add_force(m, force);
  }
}

void Body::advance(std::span<const double> velocity) {
  check_size(velocity);
  const Quaterniond rotation = exponential(angular_velocity_);

  Slip slip;
  double area = 0, furthest = 0;
  std::size_t worst = 0;
  for (std::size_t m = 0; m < marker_count(); ++m) {
    const double slip_m =
        (velocity_ + angular_velocity_.cross(arms_[m]) - fluid_at(velocity, m)).norm();
    slip.max = std::max(slip.max, slip_m);
    slip.rms += surface_.areas[m] * slip_m * slip_m;
    area += surface_.areas[m];
    const double displacement = (velocity_ + rotation * arms_[m] - arms_[m]).norm();
    if (!(displacement <= furthest)) {  // not a number counts as furthest
      furthest = displacement;
      worst = m;
    }
  }
  slip.rms = std::sqrt(slip.rms / area);
  if (!(furthest <= largest_displacement)) {
    std::ostringstream reason;
    reason << "a rigid body would move marker " << worst << " by " << furthest
           << " lattice spacings in one step (limit " << largest_displacement << ")";
    throw MotionFailure(reason.str(), worst);
  }

  slip_ = slip;
  hydrodynamic_force_ = solid_.volume * (velocity_ - state_.velocity) - force_ + film_force_;
  hydrodynamic_torque_ = apply_turned(solid_.inertia, angular_velocity_) -
                         angular_momentum_before() - torque_ + film_torque_;
  film_force_.setZero();
  film_torque_.setZero();
  if (options_.memory > 0) {
    state_.forces.resize(marker_count());
    const Quaterniond to_body = state_.orientation.conjugate();
    for (std::size_t m = 0; m < marker_count(); ++m) state_.forces[m] = to_body * forces_[m];
  }
  state_.position += velocity_;
  state_.velocity = velocity_;
  state_.orientation = (rotation * state_.orientation).normalized();
  state_.angular_velocity = angular_velocity_;
  place_markers();
}

template <class Self, class Io>
void Body::transfer_parts(Self& self, const Io& io) {
  const auto transfer = [&](std::string_view name, auto& vector) {
    io(name, {vector.data(), static_cast<std::size_t>(vector.size())});
  };
  auto& state = self.state_;
  transfer("position", state.position);
  transfer("velocity", state.velocity);
  transfer("orientation", state.orientation.coeffs());
  transfer("angular_velocity", state.angular_velocity);
  if (!state.forces.empty()) io("forces", {state.forces.data()->data(), 3 * state.forces.size()});
  transfer("next_velocity", self.velocity_);
  transfer("next_angular_velocity", self.angular_velocity_);
  transfer("hydrodynamic_force", self.hydrodynamic_force_);
  transfer("hydrodynamic_torque", self.hydrodynamic_torque_);
  io("slip_max", {&self.slip_.max, 1});
  io("slip_rms", {&self.slip_.rms, 1});
}

void Body::save(const StateWriter& write) const {
  transfer_parts(*this, write);
}

void Body::load(const StateReader& read) {
  Body loaded(*this);
  transfer_parts(loaded, read);
  check_state(loaded.state_, marker_count());
  loaded.film_force_.setZero();
  loaded.film_torque_.setZero();
  loaded.place_markers();
  *this = std::move(loaded);
}

void Body::set_film_force(const Vector3d& force, const Vector3d& torque) {
  if (!force.allFinite() || !torque.allFinite()) reject("the force of a film must be finite");
  film_force_ = force;
  film_torque_ = torque;
}

void Body::prescribe(const Vector3d& velocity, const Vector3d& angular_velocity) {
  if (options_.motion != Motion::prescribed)
    throw std::logic_error("rigid: a free body's motion cannot be prescribed");
  if (!velocity.allFinite() || !angular_velocity.allFinite())
    reject("prescribed velocities must be finite");
  velocity_ = velocity;
  angular_velocity_ = angular_velocity;
}

}  // namespace ductile::rigid
