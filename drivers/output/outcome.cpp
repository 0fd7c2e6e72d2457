#include "output/outcome.hpp"

#include <fmt/format.h>

#include <cstring>
#include <string>

#include "output/say.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {

void print_outcome(const Summary& summary, const std::filesystem::path& directory) {
  if (summary.blow_up) {
    const BlowUp& blow_up = *summary.blow_up;
    std::string where;
    if (blow_up.place) {
      const Eigen::Vector3d& at = *blow_up.place;
      where = fmt::format(" near ({:.3g}, {:.3g}, {:.3g})", at.x(), at.y(), at.z());
    }
    if (blow_up.vertex) where += fmt::format(", vertex {}", *blow_up.vertex);
    say(stderr, "ductile: {} blew up at step {} (t = {:.4g}){}: {}; likely cause: {}\n",
        blow_up.who(), blow_up.step, summary.time, where, blow_up.reason, blow_up.cause);
    say(stderr, "what was computed until then is in {}, with the last state as a row and a frame\n",
        directory.string());
  } else {
    if (summary.status == RunStatus::interrupted || summary.status == RunStatus::walltime) {
      const std::string reason = summary.status == RunStatus::walltime
                                     ? "its time is used up"
                                     : fmt::format("SIG{} came", sigabbrev_np(summary.signal));
      say(stderr,
          "ductile: {}, and the run stops at step {} (t = {:.4g}): `ductile resume {}` goes "
          "on with it\n",
          reason, summary.steps, summary.time, directory.string());
    }
    if (!summary.contact_reason.empty()) {
      say(stderr, "ductile: the run ends by a contact at step {} (t = {:.4g}): {}\n", summary.steps,
          summary.time, summary.contact_reason);
    }
    if (summary.verdict) {
      say(stdout, "{}: dz = {:.3f} at t = {:.2f} ({})\n", to_string(summary.verdict->pair_class),
          summary.dz.value_or(0), summary.time, summary.verdict->reason);
    } else {
      for (const BodySummary& body : summary.bodies) {
        say(stdout, "{}: x = {:.4f}, y = {:.4f}, z = {:.3f} at t = {:.2f}\n", body.name,
            body.position.x(), body.position.y(), body.position.z(), summary.time);
      }
    }
    for (const std::string& warning : summary.warnings) say(stdout, "warning: {}\n", warning);
    say(stdout, "{}, {:.1f} million updates a second; results in {}\n",
        duration_text(summary.wall_time), summary.updates_per_second / 1e6, directory.string());
  }
  if (summary.profile) say(stdout, "\n{}", table(*summary.profile));
}

}  // namespace ductile::drivers
