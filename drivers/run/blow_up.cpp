#include "run/blow_up.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

namespace ductile::drivers {
namespace {

using suspension::Plan;

constexpr double recent = 1;  // W^2/nu: contacts since then have to do with it
constexpr double low_tau = 0.55;

Eigen::Vector3d in_channel(Eigen::Vector3d place, double length) {
  place.z() -= length * std::floor(place.z() / length + 0.5);
  return place;
}

/// The middle of all nodes where the fluid is not finite, which spreads by a node a step to all
/// sides; nothing if that is everywhere or nowhere.
std::optional<Eigen::Vector3d> middle_of_trouble(const Plan& plan,
                                                 const suspension::FluidState& fluid) {
  const auto& nodes = plan.fluid.nodes;
  const std::size_t size = fluid.density.size();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::complex<double> around = 0;  // the circle that z is
  std::size_t count = 0;
  for (std::size_t n = 0; n < size; ++n) {
    const double u = fluid.velocity[n] + fluid.velocity[size + n] + fluid.velocity[2 * size + n];
    if (std::isfinite(fluid.density[n] + u)) continue;
    const auto nz = static_cast<std::size_t>(nodes[2]);
    const auto ny = static_cast<std::size_t>(nodes[1]);
    const std::size_t i = n / nz / ny;
    const std::size_t j = n / nz % ny;
    const std::size_t k = n % nz;
    sum += Eigen::Vector3d(static_cast<double>(i), static_cast<double>(j), 0);
    around += std::polar(1.0, 2 * std::numbers::pi * static_cast<double>(k) / nodes[2]);
    ++count;
  }
  if (count == 0 || count == size) return std::nullopt;
  Eigen::Vector3d middle = sum / static_cast<double>(count);
  middle.z() =
      nodes[2] * std::arg(around) / (2 * std::numbers::pi) + fluid.way / plan.units.length(1);
  return in_channel(plan.units.position(middle), plan.units.length(plan.length()));
}

std::optional<Eigen::Vector3d> place_of(const BlowUp& blow_up, const Plan& plan,
                                        const std::vector<suspension::SurfaceState>& surfaces) {
  for (std::size_t b = 0; b < surfaces.size(); ++b) {
    const std::vector<double>& x = surfaces[b].position;
    if (plan.bodies[b].name != blow_up.body || x.empty()) continue;
    // The vertex at fault may be at no place any more: then any other that is at one.
    std::size_t at = 3 * blow_up.vertex.value_or(0);
    for (std::size_t n = 0; n < x.size(); n += 3, at += 3) {
      const Eigen::Vector3d place = Eigen::Vector3d::Map(&x[at % x.size()]);
      if (place.allFinite()) return in_channel(place, plan.units.length(plan.length()));
    }
  }
  return std::nullopt;
}

std::string likely_cause(const BlowUp& blow_up, const Case& given, const Contacts& contacts,
                         const std::vector<std::string>& warnings) {
  const Plan& plan = given.plan;
  const double time = plan.units.time(blow_up.step);
  for (const Contact& contact : contacts.all()) {
    const bool its_own = blow_up.body.empty() ||
                         plan.bodies[contact.smallest.body].name == blow_up.body ||
                         (contact.smallest.to == suspension::Gap::To::body &&
                          plan.bodies[contact.smallest.other].name == blow_up.body);
    if (its_own && time - contact.time <= recent && !has_film(plan, contact.smallest))
      return description(plan, contact);
  }
  for (const std::string& warning : warnings) {
    const bool of_body = !blow_up.body.empty() &&
                         warning.find(fmt::format("\"{}\"", blow_up.body)) != std::string::npos;
    if (of_body && warning.find("limit") != std::string::npos) return warning;
  }
  for (const std::string& warning : warnings) {
    if (warning.starts_with(too_fast)) return warning;
  }
  if (plan.fluid.tau < low_tau) {
    return fmt::format(
        "fluid.tau = {:.4g}, so near to 1/2 that little damps what the lattice does "
        "not resolve: more nodes allow a higher one",
        plan.fluid.tau);
  }
  const auto body = std::ranges::find(plan.bodies, blow_up.body, &suspension::BodyPlan::name);
  if (body != plan.bodies.end() && body->rigid() != nullptr) {
    return "a force that moves it too fast for the time step: lower gravity, Re or fluid.tau, or "
           "take "
           "more nodes";
  }
  if (!blow_up.body.empty()) {
    return "a body too stiff for its integrator: `ductile check --thorough` tells the margins of "
           "stability";
  }
  return plan.bodies.empty() ? "a flow too fast for the lattice: more nodes"
                             : "a body too stiff or too fast for the lattice: `ductile check "
                               "--thorough` tells the margins of stability";
}

}  // namespace

BlowUp explained(BlowUp blow_up, const Case& given,
                 const std::vector<suspension::SurfaceState>& surfaces,
                 const suspension::FluidState& fluid, const Contacts& contacts,
                 const std::vector<std::string>& warnings) {
  blow_up.place = blow_up.body.empty() ? middle_of_trouble(given.plan, fluid)
                                       : place_of(blow_up, given.plan, surfaces);
  blow_up.cause = likely_cause(blow_up, given, contacts, warnings);
  return blow_up;
}

}  // namespace ductile::drivers
