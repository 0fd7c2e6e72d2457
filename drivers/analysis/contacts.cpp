#include "analysis/contacts.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace ductile::drivers {

using suspension::Gap;
using suspension::Plan;

bool Contacts::update(double time, const std::vector<Gap>& gaps) {
  bool crossing = false;
  for (const Gap& gap : gaps) {
    auto known = std::ranges::find_if(
        contacts_, [&gap](const Contact& contact) { return contact.smallest.between_same(gap); });
    if (known == contacts_.end()) {
      known = contacts_.insert(contacts_.end(), {gap, time, time});
    } else if (known->crossed() || (!gap.crossed && gap.distance >= known->smallest.distance)) {
      continue;
    } else {
      known->smallest = gap;
      known->time = time;
    }
    crossing = crossing || known->crossed();
  }
  return crossing;
}

std::string body_name(const Plan& plan, std::size_t body) {
  return fmt::format("body \"{}\"", plan.bodies[body].name);
}

std::string wall_name(const Plan& plan, const Gap& gap) {
  return gap.other == 0 ? fmt::format("the wall at x = {}", gap.side)
                        : fmt::format("the wall at y = {:.6g}",
                                      gap.side * plan.units.length(plan.half_width_y()));
}

std::string across_name(const Plan& plan, const Gap& gap) {
  if (gap.to == Gap::To::wall) return wall_name(plan, gap);
  return gap.to == Gap::To::image ? "its own periodic image" : body_name(plan, gap.other);
}

bool has_film(const Plan& plan, const Gap& gap) {
  return gap.to == Gap::To::body && suspension::has_films(plan.bodies[gap.body]) &&
         suspension::has_films(plan.bodies[gap.other]);
}

std::string description(const Plan& plan, const Contact& contact) {
  const Gap& gap = contact.smallest;
  const std::string who = body_name(plan, gap.body);
  const std::string other = across_name(plan, gap);
  if (contact.crossed()) {
    return fmt::format(
        "the surfaces of {} and {} cross at t = {:.4g}: the fluid that keeps them apart is not "
        "resolved there",
        who, other, contact.time);
  }
  if (gap.distance < 0) {
    return fmt::format(
        "the surfaces of {} and {} overlap by {:.3g} W ({:.2f} lattice spacings) at t = {:.4g}, "
        "their markers being further inside: the flow between them is not resolved since t = "
        "{:.4g}",
        who, other, -plan.units.length(gap.distance), -gap.distance, contact.time, contact.since);
  }
  return fmt::format(
      "{} came as near as {:.3g} W ({:.2f} lattice spacings) to {} at t = {:.4g}, "
      "under the {} that the kernel reaches since t = {:.4g}: {}",
      who, plan.units.length(gap.distance), gap.distance, other, contact.time,
      suspension::kernel_reach, contact.since,
      has_film(plan, gap)
          ? "what the lattice does not resolve of the film between them comes from theory"
          : "the flow between them is not resolved");
}

}  // namespace ductile::drivers
