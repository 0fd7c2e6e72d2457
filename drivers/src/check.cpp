#include "check.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "ductile/surface/biconcave.hpp"
#include "ductile/surface/mesh.hpp"
#include "errors.hpp"
#include "stability.hpp"

namespace ductile::drivers {
namespace {

constexpr double wall_gap = 2;  // the 4-point kernel's reach
constexpr double body_gap = 1;
constexpr double image_gap = 5;
constexpr double trusted_gap = 4;  // below it the flow in the gap is not resolved
constexpr double round_off = 1e-9;
constexpr double sound_mach = 0.15;
constexpr double smallest_radius = 4;     // lattice spacings
constexpr double assumed_updates = 30e6;  // node updates a second and core, fluid and bodies
constexpr int sample_frequency = 16;      // of the meshes that stand for biconcave surfaces

/// A body's surface where it starts.
class Surface {
 public:
  Surface(const BodyOptions& options, const BodySetup& setup)
      : sphere_(options.shape == BodyShape::sphere), setup_(setup), reach_(setup.radius) {
    if (sphere_) return;
    surface::Mesh mesh = surface::Biconcave(setup.radius).mesh(sample_frequency);
    for (const Eigen::Vector3d& vertex : mesh.vertices) reach_ = std::max(reach_, vertex.norm());
    surface::place(mesh, setup.rotation, setup.centre);
    points_ = std::move(mesh.vertices);
  }

  [[nodiscard]] const Eigen::Vector3d& centre() const { return setup_.centre; }
  /// Radius of a ball about the centre that holds the body.
  [[nodiscard]] double reach() const { return reach_; }

  /// Smallest and largest coordinate along an axis.
  [[nodiscard]] std::array<double, 2> extent(int axis) const {
    const double c = setup_.centre[axis];
    std::array<double, 2> range{c - setup_.radius, c + setup_.radius};
    if (sphere_) return range;
    range = {c, c};
    for (const Eigen::Vector3d& point : points_)
      range = {std::min(range[0], point[axis]), std::max(range[1], point[axis])};
    return range;
  }

  [[nodiscard]] bool contains(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d local = setup_.rotation.transpose() * (point - setup_.centre);
    if (sphere_) return local.norm() < setup_.radius;
    const Eigen::Vector3d p = local / setup_.radius;
    const double r2 = (p.x() * p.x() + p.y() * p.y()) / 1.44;
    if (r2 >= 1) return false;
    const double profile = 0.207 + 2 * r2 - 1.123 * r2 * r2;  // eq. (18)
    return std::abs(p.z()) < 0.6 * profile * std::sqrt(1 - r2);
  }

  /// Distance to `other` moved by `shift`.
  [[nodiscard]] double distance(const Surface& other, const Eigen::Vector3d& shift) const {
    const Eigen::Vector3d apart = other.centre() + shift - centre();
    if (sphere_ && other.sphere_) return apart.norm() - setup_.radius - other.setup_.radius;
    if (sphere_) return other.distance(*this, -shift);
    if (other.sphere_) {
      const Eigen::Vector3d centre_of_other = other.centre() + shift;
      double nearest = std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3d& point : points_)
        nearest = std::min(nearest, (point - centre_of_other).norm() - other.setup_.radius);
      return contains(centre_of_other) ? std::min(nearest, -round_off) : nearest;
    }
    double nearest2 = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& mine : points_) {
      const Eigen::Vector3d p = mine - shift;
      if (other.contains(p)) return -round_off;
      for (const Eigen::Vector3d& theirs : other.points_)
        nearest2 = std::min(nearest2, (p - theirs).squaredNorm());
    }
    for (const Eigen::Vector3d& theirs : other.points_)
      if (contains(theirs + shift)) return -round_off;
    return std::sqrt(nearest2);
  }

 private:
  bool sphere_;
  const BodySetup& setup_;
  double reach_;
  std::vector<Eigen::Vector3d> points_;
};

/// Distance to the nearest periodic image of another body (or to the body itself).
double nearest_image(const Surface& a, const Surface& b, const Scenario& scenario,
                     const LatticeSetup& setup) {
  const Eigen::Vector3d apart = b.centre() - a.centre();
  const int images_y = scenario.channel.side_walls ? 0 : 1;
  const double home_y = images_y == 0 ? 0 : -std::round(apart.y() / setup.nodes[1]);
  const double home_z = -std::round(apart.z() / setup.nodes[2]);
  double nearest = std::numeric_limits<double>::infinity();
  for (int y = -images_y; y <= images_y; ++y) {
    for (int z = -1; z <= 1; ++z) {
      const Eigen::Vector3d shift(0, (home_y + y) * setup.nodes[1], (home_z + z) * setup.nodes[2]);
      if ((apart + shift).norm() - a.reach() - b.reach() < nearest)
        nearest = std::min(nearest, a.distance(b, shift));
    }
  }
  return nearest;
}

std::string wall_name(const Scenario& scenario, const LatticeSetup& setup, const Gap& gap) {
  const int axis = static_cast<int>(gap.other);
  const double side = setup.bodies[gap.body].centre[axis] < setup.origin()[axis] ? -1 : 1;
  return axis == 0 ? fmt::format("the wall at x = {}", side)
                   : fmt::format("the wall at y = {}", side * scenario.channel.half_width_y);
}

std::string name(const Scenario& scenario, std::size_t body) {
  return fmt::format("body \"{}\"", scenario.bodies[body].name);
}

/// The number of nodes across that widens a gap to `wanted` lattice spacings.
int nodes_for_gap(const Scenario& scenario, const LatticeSetup& setup, double distance,
                  double wanted) {
  const double width = 2 * setup.half_width * wanted / distance;
  return static_cast<int>(std::ceil(width - round_off)) +
         (scenario.channel.walls == fluid::Boundary::regularized ? 1 : 0);
}

std::string duration(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", std::max(1.0, seconds));
  if (seconds < 5400) return fmt::format("{:.0f} min", seconds / 60);
  if (seconds < 172800) return fmt::format("{:.1f} h", seconds / 3600);
  return fmt::format("{:.1f} days", seconds / 86400);
}

std::string size(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.1f} MB", bytes / 1e6)
                     : fmt::format("{:.2f} GB", bytes / 1e9);
}

}  // namespace

std::vector<Gap> gaps(const Scenario& scenario, const LatticeSetup& setup) {
  std::vector<Surface> surfaces;
  for (std::size_t i = 0; i < scenario.bodies.size(); ++i)
    surfaces.emplace_back(scenario.bodies[i], setup.bodies[i]);
  std::vector<Gap> result;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const std::array<double, 2> half_widths{setup.half_width, setup.half_width_y};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto [low, high] = surfaces[i].extent(static_cast<int>(axis));
      if (axis == 2 || (axis == 1 && !scenario.channel.side_walls)) {
        result.push_back({Gap::To::image, i, i, setup.nodes[axis] - (high - low)});
        continue;
      }
      const double middle = setup.origin()[static_cast<int>(axis)];
      const double distance = half_widths[axis] - std::max(high - middle, middle - low);
      result.push_back({Gap::To::wall, i, axis, distance});
    }
    for (std::size_t j = i + 1; j < surfaces.size(); ++j) {
      result.push_back(
          {Gap::To::body, i, j, nearest_image(surfaces[i], surfaces[j], scenario, setup)});
    }
  }
  return result;
}

namespace {

/// What the coupling needs. The kernel reaches two nodes beyond a vertex: not onto a wall's own
/// nodes, and not round a periodic channel to where the body's other end reaches.
double least_gap(const Scenario& scenario, const Gap& gap) {
  constexpr double beyond = 0.01;
  if (gap.to == Gap::To::body) return body_gap;
  if (gap.to == Gap::To::image) return image_gap;
  return scenario.channel.walls == fluid::Boundary::regularized ? wall_gap + beyond : wall_gap;
}

}  // namespace

void check_geometry(const Scenario& scenario, const LatticeSetup& setup) {
  for (std::size_t i = 0; i < scenario.bodies.size(); ++i) {
    if (setup.bodies[i].radius < 2) {
      throw ScenarioError(
          "channel.nodes",
          fmt::format("too few nodes: the radius of {} is {:.2g} lattice spacings, at least 2 are "
                      "needed: raise channel.nodes to {}",
                      name(scenario, i), setup.bodies[i].radius,
                      nodes_for_gap(scenario, setup, setup.bodies[i].radius, 2)));
    }
  }
  for (std::size_t i = 0; !scenario.channel.side_walls && i < scenario.bodies.size(); ++i) {
    const auto [low, high] = Surface(scenario.bodies[i], setup.bodies[i]).extent(1);
    const double middle = setup.origin().y();
    if (setup.half_width_y - std::max(high - middle, middle - low) >= wall_gap - round_off)
      continue;
    throw ScenarioError("body." + scenario.bodies[i].name + ".y",
                        fmt::format("{} reaches the periodic side at y = {}, which bodies cannot "
                                    "cross: move it or make channel.half_width_y larger",
                                    name(scenario, i),
                                    std::copysign(scenario.channel.half_width_y,
                                                  setup.bodies[i].centre.y() - middle)));
  }
  const auto all = gaps(scenario, setup);
  // Overlaps first: no number of nodes cures them.
  for (const Gap& gap : all) {
    if (gap.distance > 0) continue;
    const std::string path = "body." + scenario.bodies[gap.body].name;
    if (gap.to == Gap::To::wall) {
      throw ScenarioError(path + (gap.other == 0 ? ".x" : ".y"),
                          fmt::format("{} reaches {:.3g} W into {}: move it or make it smaller",
                                      name(scenario, gap.body), -gap.distance / setup.half_width,
                                      wall_name(scenario, setup, gap)));
    }
    if (gap.to == Gap::To::image) {
      throw ScenarioError(path + ".radius",
                          fmt::format("{} overlaps its own periodic image: make the channel longer "
                                      "or the body smaller",
                                      name(scenario, gap.body)));
    }
    throw ScenarioError("body." + scenario.bodies[gap.other].name,
                        fmt::format("overlaps {}: move one of them", name(scenario, gap.body)));
  }
  for (const Gap& gap : all) {
    const double least = least_gap(scenario, gap);
    if (gap.distance >= least - round_off) continue;
    const std::string across =
        gap.to == Gap::To::wall
            ? wall_name(scenario, setup, gap)
            : (gap.to == Gap::To::image ? "its own periodic image" : name(scenario, gap.other));
    throw ScenarioError(
        "channel.nodes",
        fmt::format("too few nodes across the gap between {} and {}: {:.2f} lattice spacings, at "
                    "least {} needed: raise channel.nodes to {} or move the body",
                    name(scenario, gap.body), across, gap.distance, least,
                    nodes_for_gap(scenario, setup, gap.distance, least)));
  }
}

namespace {

/// Of each vertex of a mesh its mirror image about y = 0; nothing if one has none.
std::optional<std::vector<int>> mirror_images(const surface::Mesh& mesh) {
  const auto& x = mesh.vertices;
  std::vector<int> by_x(x.size());
  std::iota(by_x.begin(), by_x.end(), 0);
  const auto x_of = [&x](int v) { return x[static_cast<std::size_t>(v)].x(); };
  std::ranges::sort(by_x, {}, x_of);
  std::vector<int> images;
  for (const Eigen::Vector3d& vertex : x) {
    const Eigen::Vector3d image(vertex.x(), -vertex.y(), vertex.z());
    auto other = std::ranges::lower_bound(by_x, image.x() - round_off, {}, x_of);
    while (other != by_x.end() && x_of(*other) <= image.x() + round_off &&
           (x[static_cast<std::size_t>(*other)] - image).norm() > round_off)
      ++other;
    if (other == by_x.end() || x_of(*other) > image.x() + round_off) return std::nullopt;
    images.push_back(*other);
  }
  return images;
}

/// Whether a mesh of about unit size is its own mirror image about y = 0.
bool is_symmetric(const surface::Mesh& mesh) {
  const auto images = mirror_images(mesh);
  if (!images) return false;
  const auto sorted = [](std::array<int, 3> triangle) {
    std::ranges::sort(triangle);
    return triangle;
  };
  std::set<std::array<int, 3>> triangles;
  for (const auto& triangle : mesh.triangles) triangles.insert(sorted(triangle));
  return std::ranges::all_of(mesh.triangles, [&](std::array<int, 3> triangle) {
    for (int& vertex : triangle) vertex = (*images)[static_cast<std::size_t>(vertex)];
    return triangles.contains(sorted(triangle));
  });
}

}  // namespace

void check_symmetry(const Scenario& scenario, const LatticeSetup& setup) {
  if (scenario.channel.symmetry == Symmetry::none) return;
  const int least = scenario.channel.walls == fluid::Boundary::regularized ? 4 : 2;
  if (setup.nodes[1] < least) {
    throw ScenarioError("channel.symmetry",
                        fmt::format("leaves {} node{} along y, at least {} are needed: use more "
                                    "channel.nodes, or set it to \"none\"",
                                    setup.nodes[1], setup.nodes[1] == 1 ? "" : "s", least));
  }
  for (std::size_t i = 0; i < scenario.bodies.size(); ++i) {
    const BodySetup& body = setup.bodies[i];
    surface::Mesh mesh = scenario.bodies[i].shape == BodyShape::biconcave
                             ? surface::Biconcave(1).mesh(body.frequency)
                             : surface::icosphere(body.frequency, 1);
    surface::place(mesh, body.rotation, Eigen::Vector3d::Zero());
    if (is_symmetric(mesh)) continue;
    throw ScenarioError(
        "body." + scenario.bodies[i].name + ".rotation_axis",
        fmt::format("turns the mesh of {} so that it is not its own mirror image about y = 0 to "
                    "{:g} radii: use [0, 1, 0], or set channel.symmetry = \"none\"",
                    name(scenario, i), round_off));
  }
}

namespace {

/// The models of a scenario's capsules; equal capsules share one.
class Models {
 public:
  Models(const Scenario& scenario, const LatticeSetup& setup)
      : scenario_(scenario), setup_(setup) {}

  const StabilityModel& operator[](std::size_t body) {
    const StabilityProblem problem = stability_problem(scenario_, setup_, body);
    for (const auto& [known, model] : models_)
      if (known == problem) return *model;
    models_.emplace_back(problem, std::make_unique<StabilityModel>(problem));
    return *models_.back().second;
  }

 private:
  const Scenario& scenario_;
  const LatticeSetup& setup_;
  std::vector<std::pair<StabilityProblem, std::unique_ptr<StabilityModel>>> models_;
};

std::string percentages(const StabilityLoad& load, std::string_view integrator) {
  return fmt::format("{:.0f}% of the limit of {} (shear {:.0f}%, bending {:.0f}%, volume {:.0f}%)",
                     100 * load.total, integrator, 100 * load.shear, 100 * load.bending,
                     100 * load.volume);
}

/// Of the integrator that a capsule has, what there is to say.
std::string judgement(std::string_view integrator, const StabilityModel& model) {
  const std::string_view advised = advised_integrator(model);
  const auto rather = [](std::string_view said, std::string_view otherwise) {
    return fmt::format("{}; take {}", said, otherwise);
  };
  if (integrator == advised) return "the cheapest that is stable here";
  if (has_stability_limit(integrator)) {
    const double load = model.load(integrator).total;
    if (load > 1) return rather("unstable here", advised);
    if (load > sound_load) return rather("too near to its limit", advised);
    return fmt::format("stable here, as {} is", advised);
  }
  return integrator == "semi-implicit" && advised == "implicit"
             ? rather("not tried at such stiffness", advised)
             : fmt::format("stable here, but {} is too and costs less", advised);
}

/// What lowers the largest part of a load.
std::string_view cure(const StabilityLoad& load) {
  if (load.volume >= std::max(load.shear, load.bending)) return "lower volume_modulus or fluid.tau";
  if (load.bending > load.shear) return "raise edge or lower bending, mobility or fluid.tau";
  return "lower laplace or fluid.tau";
}

std::vector<std::string> find_warnings(const Scenario& scenario, const LatticeSetup& setup,
                                       Models& models) {
  std::vector<std::string> list;
  if (setup.mach() > sound_mach) {
    list.push_back(
        fmt::format("Mach number {:.2f}: errors of compressibility go as its square; "
                    "more nodes or a lower tau reduce it",
                    setup.mach()));
  }
  for (const Gap& gap : gaps(scenario, setup)) {
    if (gap.to == Gap::To::body && gap.distance < trusted_gap - round_off) {
      list.push_back(fmt::format(
          "the gap between {} and {} is {:.1f} lattice spacings, under the {} that resolve the "
          "flow in it; channel.nodes = {} would do",
          name(scenario, gap.body), name(scenario, gap.other), gap.distance, trusted_gap,
          nodes_for_gap(scenario, setup, gap.distance, trusted_gap)));
    }
  }
  for (std::size_t i = 0; i < setup.bodies.size(); ++i) {
    const BodyOptions& body = scenario.bodies[i];
    const BodySetup& lattice = setup.bodies[i];
    if (lattice.radius < smallest_radius) {
      list.push_back(
          fmt::format("the radius of {} is {:.1f} lattice spacings; under {} results are "
                      "crude",
                      name(scenario, i), lattice.radius, smallest_radius));
    }
    if (body.kind == BodyKind::rigid) continue;
    const double edge = 1.2085 * lattice.radius / lattice.frequency;
    if (body.membrane.mobility == 0 && edge < 1) {
      list.push_back(
          fmt::format("{} has edges of {:.2f} lattice spacings and no mobility: strain "
                      "that the lattice cannot see will pile up; watch its strain energy",
                      name(scenario, i), edge));
    }
    if (!has_stability_limit(body.membrane.integrator)) continue;
    const StabilityLoad load = models[i].load(body.membrane.integrator);
    if (load.total <= sound_load) continue;
    list.push_back(fmt::format("{} is at {}, {}: take membrane.integrator = \"{}\", or {}",
                               name(scenario, i), percentages(load, body.membrane.integrator),
                               load.total > 1 ? "where it is unstable" : "too near to rely on",
                               advised_integrator(models[i]), cure(load)));
  }
  const double installed =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  if (population_bytes(scenario, setup) > installed) {
    list.push_back(fmt::format("the fluid needs {} of memory, this machine has {}",
                               size(population_bytes(scenario, setup)), size(installed)));
  }
  return list;
}

}  // namespace

std::vector<std::string> warnings(const Scenario& scenario, const LatticeSetup& setup) {
  Models models(scenario, setup);
  return find_warnings(scenario, setup, models);
}

std::vector<std::string> notes(const Scenario& scenario, const LatticeSetup& setup) {
  std::vector<std::string> list;
  const auto rounded = [&list](std::string_view key, double wanted, double is) {
    if (std::abs(is - wanted) > round_off)
      list.push_back(fmt::format("{} = {} is {:.6g} in whole nodes", key, wanted, is));
  };
  rounded("channel.half_width_y", scenario.channel.half_width_y,
          setup.half_width_y / setup.half_width);
  rounded("channel.length", scenario.channel.length, setup.length / setup.half_width);
  std::vector<std::pair<double, std::string>> reduced;  // volume modulus, and who has it
  for (const BodyOptions& body : scenario.bodies) {
    const double k_v = body.membrane.volume_modulus;
    if (body.kind == BodyKind::rigid || k_v >= paper_volume_modulus) continue;
    const auto same = std::find_if(reduced.begin(), reduced.end(),
                                   [k_v](const auto& entry) { return entry.first == k_v; });
    if (same == reduced.end()) {
      reduced.emplace_back(k_v, body.name);
    } else {
      same->second += ", " + body.name;
    }
  }
  const double unit = setup.nu * setup.nu / (setup.half_width * setup.half_width);
  for (const auto& [k_v, names] : reduced) {
    list.push_back(fmt::format(
        "volume_modulus of {} is {:g} rho nu^2/W^2 ({:.2g} in lattice units), not the paper's "
        "{:g} ({:.2g}): see the volume error",
        names, k_v, k_v * unit, paper_volume_modulus, paper_volume_modulus * unit));
  }
  return list;
}

double population_bytes(const Scenario& scenario, const LatticeSetup& setup) {
  const double width = scenario.fluid.storage == fluid::Storage::single_precision ? 4 : 8;
  return 19 * width * static_cast<double>(setup.node_count());
}

double expected_speed(const Scenario& scenario, int cores, const std::optional<KnownSpeed>& known) {
  if (!known) return assumed_updates * std::max(1, cores);
  const double all = scenario.fluid.storage == fluid::Storage::single_precision
                         ? known->single_precision
                         : known->double_precision;
  return all * std::clamp(cores, 1, known->ranks) / known->ranks;
}

double estimated_seconds(const LatticeSetup& setup, double speed) {
  return static_cast<double>(setup.node_count()) * static_cast<double>(setup.total_steps) / speed;
}

std::string report(const Scenario& scenario, const LatticeSetup& setup, int cores,
                   const std::optional<KnownSpeed>& known) {
  const ChannelOptions& channel = scenario.channel;
  Models models(scenario, setup);
  std::string text;
  const auto line = [&text](std::string_view label, const std::string& content) {
    text += fmt::format("{:<10} {}\n", label, content);
  };
  line("scenario", fmt::format("{}, {} {}", scenario.name, scenario.bodies.size(),
                               scenario.bodies.size() == 1 ? "body" : "bodies"));
  line("lattice",
       fmt::format("{} x {} x {} = {} nodes{}, {}, W = {} dx", setup.nodes[0], setup.nodes[1],
                   setup.nodes[2], setup.node_count(),
                   channel.symmetry == Symmetry::y ? " at y >= 0, half of the channel" : "",
                   channel.walls == fluid::Boundary::halfway ? "half-way walls"
                                                             : "regularized walls on nodes",
                   setup.half_width));
  line("", fmt::format("half-width along y {:.6g} W, length {:.6g} W",
                       setup.half_width_y / setup.half_width, setup.length / setup.half_width));
  line("fluid",
       fmt::format(
           "tau = {}, nu = {:.6g}, {}, populations in {} precision", setup.tau, setup.nu,
           scenario.fluid.collision == fluid::Collision::bgk ? "bgk" : "trt",
           scenario.fluid.storage == fluid::Storage::double_precision ? "double" : "single"));
  line("flow", fmt::format("Re = {}, U_max = {:.6g}, body force {:.6g}, Mach number {:.3f}",
                           channel.reynolds, setup.u_max, setup.alpha, setup.mach()));
  line("time", fmt::format("{:.6g} steps per W^2/nu, {} steps until t = {}", setup.steps_per_time,
                           setup.total_steps, scenario.run.time_limit));
  for (std::size_t i = 0; i < setup.bodies.size(); ++i) {
    const BodyOptions& body = scenario.bodies[i];
    const BodySetup& b = setup.bodies[i];
    const bool capsule = body.kind == BodyKind::capsule;
    line("body",
         fmt::format("{}: {}{}, a = {:.4g} dx, at ({}, {}, {}) W", body.name,
                     body.shape == BodyShape::biconcave ? "biconcave " : "",
                     capsule ? "capsule" : "rigid sphere", b.radius, body.x, body.y, body.z));
    line("", fmt::format("mesh of {} triangles, mean edge of its sphere {:.3g} dx",
                         20LL * b.frequency * b.frequency, 1.2085 * b.radius / b.frequency));
    if (!capsule) {
      line("", fmt::format("density ratio {}, {} forcing iterations, memory {}", body.density_ratio,
                           body.rigid.iterations, body.rigid.memory));
      continue;
    }
    line("", fmt::format("La = {}; in lattice units k_s = {:.4g}, k_a = {:.4g}, k_b = {:.4g}, "
                         "k_v = {:.4g}",
                         body.laplace, b.moduli.k_s, b.moduli.k_a, b.moduli.k_b, b.moduli.k_v));
    const std::string& integrator = body.membrane.integrator;
    line("", "stability: " + percentages(models[i].load("explicit-euler"), "explicit-euler"));
    if (integrator != "explicit-euler" && has_stability_limit(integrator))
      line("", "stability: " + percentages(models[i].load(integrator), integrator));
    line("", fmt::format("integrator {}: {}", integrator, judgement(integrator, models[i])));
  }
  const auto all = gaps(scenario, setup);
  for (const Gap::To to : {Gap::To::wall, Gap::To::body}) {
    const Gap* smallest = nullptr;
    for (const Gap& gap : all) {
      if (gap.to == to && (smallest == nullptr || gap.distance < smallest->distance))
        smallest = &gap;
    }
    if (smallest == nullptr) continue;
    line("gap", fmt::format("{:.4g} dx from {} to {}, the smallest to a {}", smallest->distance,
                            name(scenario, smallest->body),
                            to == Gap::To::wall ? wall_name(scenario, setup, *smallest)
                                                : name(scenario, smallest->other),
                            to == Gap::To::wall ? "wall" : "body"));
  }
  line("memory", size(population_bytes(scenario, setup)) + " of populations");
  if (known) cores = std::min(cores, known->ranks);  // more were not measured
  const double speed = expected_speed(scenario, cores, known);
  line("duration",
       fmt::format(
           "about {} until the time limit on {} core{}, at {:.0f} million updates a second, "
           "{}",
           duration(estimated_seconds(setup, speed)), cores, cores == 1 ? "" : "s", speed / 1e6,
           known ? "as `ductile bench` has found here"
                 : "a guess: run `ductile bench` once for a better one"));
  for (const std::string& note : notes(scenario, setup)) line("note", note);
  for (const std::string& warning : find_warnings(scenario, setup, models))
    line("warning", warning);
  return text;
}

}  // namespace ductile::drivers
