#include "checks/disk.hpp"

#include <algorithm>
#include <cmath>

#include "checks/speed.hpp"
#include "ductile/surface/mesh.hpp"
#include "ductile/suspension/sample.hpp"

namespace ductile::drivers {
namespace {

constexpr double number_as_text = 19;  // with its comma
constexpr double vector = 3 * sizeof(double);
constexpr double checkpoint_vectors = 5;  // of a vertex: where it is, velocity, forces, memory
constexpr double frame_overhead = 6000;   // HDF5's, the link in run.h5, and run.xdmf
constexpr double field_node = 4 * sizeof(float);

double times(double interval, double end) {
  return interval > 0 ? std::floor(end / interval) + 1 : 0;
}

}  // namespace

double disk_needed(const Case& given) {
  const suspension::Plan& plan = given.plan;
  const auto end = static_cast<double>(given.schedule.end);
  double columns = 3;
  double shown = 0;
  double kept = population_bytes(plan);
  for (const suspension::BodyPlan& body : plan.bodies) {
    const bool capsule = body.capsule() != nullptr;
    for (const suspension::Quantity& quantity : suspension::quantities())
      columns += quantity.applies(capsule) ? 1 : 0;
    const auto vertices = static_cast<double>(surface::vertex_count(body.frequency));
    shown += vertices * vector * (capsule ? 3 : 2) + frame_overhead;
    kept += vertices * vector * checkpoint_vectors;
  }
  const Schedule& schedule = given.schedule;
  const double mirrored = plan.fluid.mirror == fluid::Mirror::none ? 1 : 2;
  const double fluid = static_cast<double>(plan.node_count()) * mirrored * field_node;
  const double frames = std::max(times(schedule.surfaces, end), times(schedule.fields, end));
  return times(schedule.rows, end) * columns * number_as_text + frames * (shown + frame_overhead) +
         times(schedule.fields, end) * fluid + 2 * kept;
}

}  // namespace ductile::drivers
