#include "ductile/membrane/capsule.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

#include "state.hpp"

namespace ductile::membrane {
namespace {

using Eigen::Vector3d;

std::string message(VertexFailure::Reason reason, int vertex, double displacement) {
  const std::string which = "vertex " + std::to_string(vertex);
  switch (reason) {
    case VertexFailure::Reason::force_not_finite:
      return "the force on " + which + " is not finite: a triangle beside it has collapsed";
    case VertexFailure::Reason::velocity_not_finite:
      return "the velocity of " + which + " is not finite: the fluid has blown up";
    case VertexFailure::Reason::too_fast:
      break;
  }
  std::ostringstream text;
  text << which << " moves " << displacement << " lattice spacings in one step, more than "
       << Capsule::max_displacement
       << ": the membrane is too stiff for its integrator, or the flow too fast for the time step";
  return text.str();
}

// The span stays valid: a sequential vector on the host keeps its array where it is.
std::span<const double> view(const VecPtr& vec) {
  return VecArray<const double>(vec.get()).span();
}

void copy(std::span<const double> from, Vec to) {
  const VecArray<double> array(to);
  if (from.size() != array.size()) {
    throw std::invalid_argument("capsule: an array of " + std::to_string(from.size()) +
                                " numbers where " + std::to_string(array.size()) + " are needed");
  }
  std::copy(from.begin(), from.end(), array.data());
}

void copy(const VecPtr& from, std::span<double> to) {
  const std::span<const double> numbers = view(from);
  if (numbers.size() != to.size()) {
    throw std::invalid_argument("capsule: an array of " + std::to_string(to.size()) +
                                " numbers where " + std::to_string(numbers.size()) + " are needed");
  }
  std::copy(numbers.begin(), numbers.end(), to.begin());
}

std::string integrator_part(std::string_view name) {
  return "integrator/" + std::string(name);
}

void require_finite(const VecPtr& vec, VertexFailure::Reason reason) {
  const std::span<const double> numbers = view(vec);
  const auto bad = std::find_if_not(numbers.begin(), numbers.end(),
                                    [](double number) { return std::isfinite(number); });
  if (bad != numbers.end()) {
    throw VertexFailure(reason, static_cast<int>((bad - numbers.begin()) / 3),
                        std::numeric_limits<double>::quiet_NaN());
  }
}

}  // namespace

VertexFailure::VertexFailure(Reason reason, int vertex, double displacement)
    : std::runtime_error(message(reason, vertex, displacement)),
      reason_(reason),
      vertex_(vertex),
      displacement_(displacement) {}

Capsule::Capsule(const surface::Mesh& reference, std::span<const Vector3d> positions,
                 const Moduli& moduli, const CapsuleOptions& options,
                 std::span<const Vector3d> velocities)
    : shell_(reference, moduli),
      state_{shell_.create_vec(), shell_.create_vec(), shell_.create_vec()},
      mobility_(shell_.create_vec()),
      fluid_velocity_(shell_.create_vec()),
      result_(shell_.create_vec()),
      make_integrator_(options.integrator) {
  const auto require = [&reference](std::span<const Vector3d> vectors, const std::string& one,
                                    const std::string& many) {
    if (vectors.size() != reference.vertices.size()) {
      throw std::invalid_argument("capsule: " + std::to_string(vectors.size()) + " " + many +
                                  " for a reference of " +
                                  std::to_string(reference.vertices.size()) + " vertices");
    }
    for (std::size_t i = 0; i < vectors.size(); ++i) {
      if (!vectors[i].allFinite()) {
        throw std::invalid_argument("capsule: the " + one + " of vertex " + std::to_string(i) +
                                    " is not finite");
      }
    }
  };
  require(positions, "position", "positions");
  if (!velocities.empty()) require(velocities, "velocity", "velocities");
  if (!(options.mobility >= 0) || !std::isfinite(options.mobility)) {
    throw std::invalid_argument("capsule: mobility " + std::to_string(options.mobility) +
                                " must be finite and not negative");
  }
  if (options.mobility > 0 && !(options.viscosity > 0)) {
    throw std::invalid_argument("capsule: viscosity " + std::to_string(options.viscosity) +
                                " must be positive");
  }
  {
    const VecArray<double> x(state_.positions.get());
    const VecArray<double> eps(mobility_.get());
    const VecArray<double> v(state_.velocities.get());
    for (std::size_t i = 0; i < positions.size(); ++i) {
      Vector3d::Map(&x[3 * i]) = positions[i];
      if (!velocities.empty()) Vector3d::Map(&v[3 * i]) = velocities[i];
      if (options.mobility > 0) {
        Vector3d::Map(&eps[3 * i])
            .setConstant(options.mobility / (options.viscosity * shell_.vertex_areas()[i]));
      }
    }
  }
  integrator_ = make_integrator_(shell_, mobility_.get());
}

std::span<const double> Capsule::positions() const {
  return view(state_.positions);
}
std::span<const double> Capsule::velocities() const {
  return view(state_.velocities);
}
std::span<const double> Capsule::forces() const {
  return view(state_.forces);
}

void Capsule::predict_force(std::span<double> force) {
  integrator_->predict_force(state_, result_.get());
  require_finite(result_, VertexFailure::Reason::force_not_finite);
  copy(result_, force);
  std::swap(state_.forces, result_);
}

void Capsule::correct_force(std::span<const double> fluid_velocity, const Response& response,
                            std::span<double> increment) {
  copy(fluid_velocity, fluid_velocity_.get());
  integrator_->correct_force(state_, fluid_velocity_.get(), response, result_.get());
  require_finite(result_, VertexFailure::Reason::force_not_finite);
  copy(result_, increment);
  petsc_check(VecAXPY(state_.forces.get(), 1.0, result_.get()));
}

void Capsule::advance(std::span<const double> fluid_velocity) {
  copy(fluid_velocity, fluid_velocity_.get());
  integrator_->advance(state_, fluid_velocity_.get(), result_.get());
  require_finite(result_, VertexFailure::Reason::velocity_not_finite);
  const std::span<const double> v = view(result_);
  double slip = 0;
  for (int i = 0; i < vertex_count(); ++i) {
    const auto velocity = Vector3d::Map(&v[3 * i]);
    slip = std::max(slip, (velocity - Vector3d::Map(&fluid_velocity[3 * i])).squaredNorm());
    const double displacement = velocity.norm();
    if (displacement > max_displacement)
      throw VertexFailure(VertexFailure::Reason::too_fast, i, displacement);
  }
  petsc_check(VecAXPY(state_.positions.get(), 1.0, result_.get()));
  std::swap(state_.velocities, result_);
  slip_ = std::sqrt(slip);
  integrator_->accept();
}

template <class Slip, class Io>
void Capsule::transfer_parts(const State& state, Slip& slip, const Io& io) {
  transfer(io, "positions", state.positions);
  transfer(io, "velocities", state.velocities);
  transfer(io, "forces", state.forces);
  transfer(io, "slip", slip);
}

void Capsule::save(const StateWriter& write) const {
  transfer_parts(state_, slip_, write);
  integrator_->save([&](std::string_view name, std::span<const double> numbers) {
    write(integrator_part(name), numbers);
  });
}

void Capsule::load(const StateReader& read) {
  State state{shell_.create_vec(), shell_.create_vec(), shell_.create_vec()};
  double slip = 0;
  transfer_parts(state, slip, read);
  std::unique_ptr<Integrator> integrator = make_integrator_(shell_, mobility_.get());
  integrator->load([&](std::string_view name, std::span<double> numbers) {
    read(integrator_part(name), numbers);
  });
  state_ = std::move(state);
  slip_ = slip;
  integrator_ = std::move(integrator);
}

double Capsule::volume_error() const {
  return shape().volume / shell_.reference_volume() - 1;
}

}  // namespace ductile::membrane
