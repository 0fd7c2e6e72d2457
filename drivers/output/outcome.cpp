#include "output/outcome.hpp"

#include <fmt/format.h>

#include <string>

#include "scenario/text.hpp"

namespace ductile::drivers {

void print_outcome(const Summary& summary, const std::filesystem::path& directory) {
  if (summary.blow_up) {
    fmt::print(stderr, "ductile: {} blew up at step {} (t = {:.4g}): {}\n", summary.blow_up->who(),
               summary.blow_up->step, summary.time, summary.blow_up->reason);
    fmt::print(stderr, "what was computed until then is in {}\n", directory.string());
  } else {
    if (!summary.contact_reason.empty()) {
      fmt::print(stderr, "ductile: the run ends by a contact at step {} (t = {:.4g}): {}\n",
                 summary.steps, summary.time, summary.contact_reason);
    }
    if (summary.verdict) {
      fmt::print("{}: dz = {:.3f} at t = {:.2f} ({})\n", to_string(summary.verdict->pair_class),
                 summary.dz.value_or(0), summary.time, summary.verdict->reason);
    } else {
      for (const BodySummary& body : summary.bodies) {
        fmt::print("{}: x = {:.4f}, y = {:.4f}, z = {:.3f} at t = {:.2f}\n", body.name,
                   body.position.x(), body.position.y(), body.position.z(), summary.time);
      }
    }
    for (const std::string& warning : summary.warnings) fmt::print("warning: {}\n", warning);
    fmt::print("{}, {:.1f} million updates a second; results in {}\n",
               duration_text(summary.wall_time), summary.updates_per_second / 1e6,
               directory.string());
  }
  if (summary.profile) fmt::print("\n{}", table(*summary.profile));
}

}  // namespace ductile::drivers
