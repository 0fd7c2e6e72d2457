#include "scenario/keys.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "ductile/membrane/integrator.hpp"
#include "ductile/surface/shape.hpp"
#include "scenario/text.hpp"

namespace ductile::drivers {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Range {
  double low = -infinity;
  double high = infinity;
  bool low_open = false;

  [[nodiscard]] bool contains(double value) const {
    return (low_open ? value > low : value >= low) && value <= high;
  }
  [[nodiscard]] std::string text() const {
    if (low == -infinity) return "";
    if (high == infinity) return fmt::format(" {} {}", low_open ? "above" : "of at least", low);
    if (low_open) return fmt::format(" above {} and at most {}", low, high);
    return fmt::format(" from {} to {}", low, high);
  }
};

constexpr Range any{};
constexpr Range between(double low, double high) {
  return {low, high, false};
}
constexpr Range above(double low, double high = infinity) {
  return {low, high, true};
}

// TOML tells 1 from 1.0; both are numbers here, and floats are written so that they stay floats.
std::string written(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}
std::string written(int value) {
  return fmt::format("{}", value);
}
std::string written(bool value) {
  return value ? "true" : "false";
}
std::string written(const std::string& value) {
  return in_quotes(value);
}
template <std::size_t N>
std::string written(const std::array<double, N>& value) {
  std::string text;
  for (const double component : value) text += (text.empty() ? "[" : ", ") + written(component);
  return text + "]";
}

std::optional<double> number_of(const toml::node& node, const Range& range) {
  if (!node.is_number()) return std::nullopt;
  const double value = node.value<double>().value_or(NAN);
  return std::isfinite(value) && range.contains(value) ? std::optional(value) : std::nullopt;
}

/// On the command line what is no TOML is taken as a word, and so is .05.
std::string point_hint(const toml::node& node) {
  const std::string text = node.value<std::string>().value_or("");
  const auto digit = [&text](std::size_t at) {
    return at < text.size() && text[at] >= '0' && text[at] <= '9';
  };
  for (std::size_t at = text.find('.'); at != std::string::npos; at = text.find('.', at + 1)) {
    if (digit(at + 1) != (at > 0 && digit(at - 1)))
      return "; TOML wants a digit on both sides of the point, as in 0.5";
  }
  return "";
}

/// Whatever the type, `convert` turns a node into a value, or into nothing if it is not `expected`.
template <class T, class Value, class Convert>
Key<T> make_key(std::string_view name, Value T::*member, std::string expected,
                std::string_view unit, std::string_view meaning, std::string_view default_rule,
                Convert convert) {
  auto read = [member, expected, convert](T& table, const toml::node& node) {
    auto value = convert(node);
    if (!value) throw Complaint{"must be " + expected + point_hint(node)};
    table.*member = *std::move(value);
  };
  auto write = [member](const T& table) { return written(table.*member); };
  return {
      name, std::move(expected), unit, meaning, default_rule, std::move(read), std::move(write)};
}

template <class T>
Key<T> number(std::string_view name, double T::*member, Range range, std::string_view unit,
              std::string_view meaning, std::string_view default_rule = "",
              std::string_view advice = "") {
  return make_key(name, member, fmt::format("a number{}{}", range.text(), advice), unit, meaning,
                  default_rule, [range](const toml::node& node) { return number_of(node, range); });
}

/// A number, or the word for what the program finds by itself, which is no value.
template <class T>
Key<T> number_or(std::string_view name, std::optional<double> T::*member, Range range,
                 std::string_view word, std::string_view unit, std::string_view meaning) {
  using Value = std::optional<double>;
  const std::string quoted = in_quotes(std::string(word));
  const std::string expected = fmt::format("{}, or a number{}", quoted, range.text());
  auto read = [member, range, expected, word](T& table, const toml::node& node) {
    if (node.value<std::string>() == word) {
      table.*member = std::nullopt;
    } else if (const Value value = number_of(node, range)) {
      table.*member = value;
    } else {
      const std::string hint =
          node.is_string() ? suggestion(node.value<std::string>().value_or(""), {word}) : "";
      throw Complaint{"must be " + expected + (hint.empty() ? point_hint(node) : ";" + hint)};
    }
  };
  auto write = [member, quoted](const T& table) {
    const Value& value = table.*member;
    return value ? written(*value) : quoted;
  };
  return {name, expected, unit, meaning, "", std::move(read), std::move(write)};
}

template <class T>
Key<T> whole(std::string_view name, int T::*member, Range range, std::string_view unit,
             std::string_view meaning) {
  return make_key(name, member, "a whole number" + range.text(), unit, meaning, "",
                  [range](const toml::node& node) -> std::optional<int> {
                    if (!node.is_integer()) return std::nullopt;
                    const std::int64_t value = node.value<std::int64_t>().value_or(0);
                    if (!range.contains(static_cast<double>(value))) return std::nullopt;
                    return static_cast<int>(value);
                  });
}

template <class T, std::size_t N>
Key<T> numbers(std::string_view name, std::array<double, N> T::*member, std::string_view unit,
               std::string_view meaning) {
  return make_key(name, member, fmt::format("an array of {} numbers", N), unit, meaning, "",
                  [](const toml::node& node) -> std::optional<std::array<double, N>> {
                    const toml::array* array = node.as_array();
                    if (array == nullptr || array->size() != N) return std::nullopt;
                    std::array<double, N> value{};
                    for (std::size_t i = 0; i < N; ++i) {
                      const auto component = number_of((*array)[i], any);
                      if (!component) return std::nullopt;
                      value[i] = *component;
                    }
                    return value;
                  });
}

template <class T>
Key<T> flag(std::string_view name, bool T::*member, std::string_view meaning) {
  return make_key(name, member, "true or false", "", meaning, "",
                  [](const toml::node& node) -> std::optional<bool> {
                    return node.is_boolean() ? node.value<bool>() : std::nullopt;
                  });
}

/// One of a few names, each standing for a value.
template <class T, class Value>
Key<T> choice(std::string_view name, Value T::*member,
              std::vector<std::pair<std::string_view, Value>> options, std::string_view meaning,
              std::string_view default_rule = "") {
  std::string expected;
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < options.size(); ++i) {
    expected += i == 0 ? "" : (i + 1 == options.size() ? " or " : ", ");
    expected += in_quotes(options[i].first);
    names.push_back(options[i].first);
  }
  auto read = [member, options, names, expected](T& table, const toml::node& node) {
    const std::string given = node.value<std::string>().value_or("");
    for (const auto& [option, value] : options) {
      if (node.is_string() && option == given) {
        table.*member = value;
        return;
      }
    }
    const std::string hint = node.is_string() ? suggestion(given, names) : "";
    throw Complaint{"must be " + expected + (hint.empty() ? "" : ";" + hint)};
  };
  auto write = [member, options](const T& table) {
    for (const auto& [option, value] : options)
      if (table.*member == value) return in_quotes(option);
    return in_quotes("");
  };
  return {name, std::move(expected), "", meaning, default_rule, std::move(read), std::move(write)};
}

template <class T>
Key<T> identifier(std::string_view name, std::string T::*member, std::string_view meaning,
                  std::string_view default_rule) {
  return make_key(name, member, std::string(name_rule), "", meaning, default_rule,
                  [](const toml::node& node) -> std::optional<std::string> {
                    const std::string text = node.value<std::string>().value_or("");
                    return node.is_string() && is_name(text) ? std::optional(text) : std::nullopt;
                  });
}

/// Names that stand for themselves.
std::vector<std::pair<std::string_view, std::string>> themselves(
    const std::vector<std::string_view>& names) {
  std::vector<std::pair<std::string_view, std::string>> options;
  options.reserve(names.size());
  for (const std::string_view name : names) options.emplace_back(name, name);
  return options;
}

}  // namespace

const std::vector<Key<Scenario>>& root_keys() {
  static const std::vector<Key<Scenario>> keys = {
      identifier("name", &Scenario::name, "Name of the run and of its directory",
                 "the file's name"),
  };
  return keys;
}

const std::vector<Key<ChannelOptions>>& channel_keys() {
  using C = ChannelOptions;
  static const std::vector<Key<C>> keys = {
      whole("nodes", &C::nodes, between(8, most_nodes), "",
            "Nodes N across the width 2W along x; see walls for what W then is"),
      choice<C, fluid::Boundary>(
          "walls", &C::walls,
          {{"halfway", fluid::Boundary::halfway}, {"regularized", fluid::Boundary::regularized}},
          "No-slip walls: half-way bounce-back (2W = N spacings), or on the outermost nodes by the "
          "regularized method, as in the paper (2W = N - 1)"),
      flag("side_walls", &C::side_walls,
           "Walls at y = -half_width_y and half_width_y; false: periodic, a flow between plates"),
      choice<C, Symmetry>(
          "symmetry", &C::symmetry, {{"none", Symmetry::none}, {"y", Symmetry::y}},
          "Symmetry of flow and bodies about the plane y = 0: if \"y\", only the fluid at y >= 0 "
          "is computed"),
      number("half_width_y", &C::half_width_y, between(0.25, 20), "W",
             "Half-width along y, rounded to whole nodes; 1 is the square channel"),
      number("length", &C::length, between(1, 1000), "W",
             "Length of the periodic channel along z, rounded to whole nodes"),
      number("reynolds", &C::reynolds, between(0, 1000), "",
             "Re = 2 W U_max/nu, U_max the empty channel's; 0: no driving force"),
      numbers("wall_velocity", &C::wall_velocity, "nu/W",
              "Velocities along z of the walls at x = -1 and x = 1"),
      numbers("gravity", &C::gravity, "nu^2/W^3",
              "Acceleration that acts on the excess mass of rigid bodies"),
      choice<C, suspension::Start>(
          "start", &C::start,
          {{"developed", suspension::Start::developed}, {"rest", suspension::Start::rest}},
          "The flow at t = 0: developed, as without bodies, or at rest"),
  };
  return keys;
}

const std::vector<Key<FluidOptions>>& fluid_keys() {
  using F = FluidOptions;
  static const std::vector<std::pair<std::string_view, fluid::Precision>> precisions = {
      {"double", fluid::Precision::double_precision},
      {"single", fluid::Precision::single_precision}};
  static const std::vector<Key<F>> keys = {
      number("tau", &F::tau, above(0.5, 1), "",
             "Relaxation time; nu = (tau - 1/2)/3 in lattice units sets the time step", "",
             " (at 1/2 the viscosity vanishes; above 1 capsules drift to wrong places)"),
      choice<F, fluid::Collision>("collision", &F::collision,
                                  {{"bgk", fluid::Collision::bgk}, {"trt", fluid::Collision::trt}},
                                  "Collision operator: one relaxation time, or two"),
      number("magic", &F::magic, above(0, 0.25), "",
             "Of trt: (tau - 1/2)(tau_odd - 1/2); 3/16 puts half-way walls exactly half way, "
             "(tau - 1/2)^2 is bgk",
             "", " (above 1/4 bodies drift to wrong places)"),
      choice<F, fluid::Equilibrium>(
          "equilibrium", &F::equilibrium,
          {{"compressible", fluid::Equilibrium::compressible},
           {"incompressible", fluid::Equilibrium::incompressible}},
          "Whether the density weighs in the momentum, eq. (3), or stands for the pressure alone, "
          "which is the more accurate where bodies all go with the lattice, and worse, if not "
          "unstable, where they move on it",
          "incompressible; with frame = \"walls\", gravity, walls that move or reynolds = 0 "
          "compressible"),
      choice<F, LatticeFrame>(
          "frame", &F::frame, {{"walls", LatticeFrame::walls}, {"bodies", LatticeFrame::bodies}},
          "What the lattice moves with along z: the walls, or the bodies, with the mean of their "
          "velocities. Errors that grow with a body's velocity on the lattice, in its lift above "
          "all, then all but vanish; results are told in the walls' frame either way"),
      choice<F, fluid::Precision>("storage", &F::storage, precisions,
                                  "Precision in which the populations are stored"),
      choice<F, fluid::Precision>("arithmetic", &F::arithmetic, precisions,
                                  "Precision in which the fluid collides, and bodies spread and "
                                  "interpolate; single needs single storage. Bodies are always in "
                                  "double",
                                  "the storage's"),
  };
  return keys;
}

const std::vector<Key<MembraneOptions>>& membrane_keys() {
  using M = MembraneOptions;
  static const std::vector<Key<M>> keys = {
      choice<M, membrane::StrainLaw>("law", &M::law,
                                     {{"skalak", membrane::StrainLaw::skalak},
                                      {"neo-hookean", membrane::StrainLaw::neo_hookean}},
                                     "In-plane strain energy; k_s/3 is the shear modulus of both"),
      number("area_ratio", &M::area_ratio, between(0, 1000), "",
             "k_a/k_s, resistance to dilation (skalak)"),
      number("bending", &M::bending, between(0, 1), "",
             "k_b/(k_s a^2), eq. (10) taken literally; a less the retraction"),
      number("volume_modulus", &M::volume_modulus, between(0, 1e9), "rho nu^2/W^2", "k_v, eq. (11)",
             "the paper's 75000, or what 1.5 in lattice units comes to if that is less"),
      number("mobility", &M::mobility, between(0, 0.1), "dx/eta",
             "Drift of the membrane through the fluid per elastic force per area: relaxes strain "
             "that the lattice cannot see; 0 is the paper's pure method"),
      number_or(
          "retraction", &M::retraction, between(0, 1), "felt", "dx",
          "How far inside of its surface a capsule's membrane is computed, as the kernel makes it "
          "felt further out than it is; a sphere's moduli are adapted to it. felt: what makes it "
          "felt where it is, 0.4 + 1.4 dx/a for a sphere and 0.4 for a cell at tau = 1. "
          "0: neither, the paper's method"),
      choice<M, std::string>("integrator", &M::integrator, themselves(membrane::integrator_names()),
                             "How the membrane advances in time; implicit: at any stiffness"),
      number("theta", &M::theta, between(0.5, 1), "",
             "Implicit integrators: 0.5 is the fluid's own answer, without slip; 1 damps most"),
      whole("substeps", &M::substeps, between(1, 1000), "",
            "Implicit integrators: into how many the time step is divided"),
      whole("step_cuts", &M::step_cuts, between(0, 20), "",
            "Implicit integrators: how often a step that was not solved is tried again with twice "
            "as many substeps"),
      number("edge", &M::edge, between(0.3, 4), "dx", "Mean edge of the surface's mesh"),
      whole("frequency", &M::frequency, between(0, 1024), "",
            "Mesh of 20 n^2 triangles (the paper's 20480: 32); 0: as edge demands"),
  };
  return keys;
}

const std::vector<Key<RigidOptions>>& rigid_keys() {
  using R = RigidOptions;
  static const std::vector<Key<R>> keys = {
      whole("iterations", &R::iterations, between(1, 100), "",
            "Iterations of multi-direct forcing in a step"),
      number("memory", &R::memory, between(0, 0.95), "",
             "Share of the last step's force with which a step's iterations begin: 2 iterations "
             "with 0.9 leave as little slip as 5 with 0, the paper's method"),
      number_or(
          "retraction", &R::retraction, between(0, 2), "felt", "dx",
          "How far inside of its surface a body's markers lie, as the kernel makes it felt "
          "further out than they are. felt: what makes it felt where it is at this slip, "
          "at tau = 1 2.7 dx/a; without slip 0.4 + 1.4 dx/a, and 0.2 more for a solid. 0: on the "
          "surface, the paper's method"),
      number_or(
          "slip", &R::slip, between(0, 1), "felt", "dx",
          "How far fluid and body slip along a body's surface at its markers, in dx/eta times the "
          "force per area: what the kernel misses of the fluid's answer. felt: with the retraction "
          "what makes the surface felt where it is, 0.1 at a = 8 dx; 0 of bodies that are solid, "
          "no spheres, or lighter than the fluid, and with a retraction that is given. Of a film "
          "between two spheres with slip, neither lighter than the fluid, that is too thin for the "
          "lattice lubrication theory says what is missing. 0: the paper's method"),
      number("roughness", &R::roughness, between(1e-4, 0.1), "radii",
             "Height of a sphere's roughness: two spheres with slip, neither lighter than the "
             "fluid, touch where the gap between them is the mean of theirs"),
      choice<R, suspension::Interior>(
          "interior", &R::interior,
          {{"fluid", suspension::Interior::fluid}, {"solid", suspension::Interior::solid}},
          "What fills the surface: fluid that it alone moves, the paper's method, which follows a "
          "change of spin only within a^2/(20 nu); or a solid, made by inner shells of markers",
          "fluid, or solid for a body that is too light to be stable with fluid inside"),
      number("edge", &R::edge, between(0.3, 4), "dx", "Mean edge of the surface's mesh"),
      whole("frequency", &R::frequency, between(0, 1024), "",
            "Mesh of 20 n^2 triangles (the paper's 20480: 32); 0: as edge demands"),
  };
  return keys;
}

const std::vector<Key<BodyOptions>>& body_keys() {
  using B = BodyOptions;
  static const std::vector<Key<B>> keys = {
      identifier("name", &B::name, "Name in outputs and in --set body.NAME.key=value",
                 "body1, body2, ..."),
      choice<B, BodyKind>("kind", &B::kind,
                          {{"capsule", BodyKind::capsule}, {"rigid", BodyKind::rigid}},
                          "Elastic membrane, or rigid"),
      choice<B, std::string>("shape", &B::shape, themselves(surface::shape_names()),
                             "biconcave (capsules only): the cell of eq. (18), dimple axis along z "
                             "before rotation: the disc stands across the flow"),
      number("radius", &B::radius, above(0, 20), "W",
             "a; of a biconcave cell, that of the sphere from which eq. (18) makes it"),
      number("x", &B::x, any, "W", "Initial position of the centre, from the axis"),
      number("y", &B::y, any, "W", "Initial position of the centre, from the axis"),
      number("z", &B::z, any, "W",
             "Initial position of the centre along the flow, from the middle of the channel"),
      numbers("rotation_axis", &B::rotation_axis, "",
              "Axis of the initial rotation, of any length"),
      number("rotation_angle", &B::rotation_angle, between(-360, 360), "degrees",
             "Angle of the initial rotation"),
  };
  return keys;
}

const std::vector<Key<BodyOptions>>& capsule_keys() {
  static const std::vector<Key<BodyOptions>> keys = {
      number("laplace", &BodyOptions::laplace, between(0, 1e7), "",
             "La = k_s a/(rho nu^2), the softness", "none: every capsule states it"),
  };
  return keys;
}

const std::vector<Key<BodyOptions>>& rigid_body_keys() {
  static const std::vector<Key<BodyOptions>> keys = {
      number("density_ratio", &BodyOptions::density_ratio, between(0.5, 5), "",
             "Density over that of the fluid"),
  };
  return keys;
}

const std::vector<Key<RunLimits>>& run_keys() {
  using R = RunLimits;
  static const std::vector<Key<R>> keys = {
      number("time_limit", &R::time_limit, above(0, 1e5), "W^2/nu", "The run stops at this time"),
      number("stop_distance", &R::stop_distance, above(0), "W",
             "The run stops when a pair's axial distance has come to this from below",
             "10, or in a shorter channel its length less 2, or half its length if that is more"),
      flag("until_decided", &R::until_decided, "Stop as soon as the verdict of a pair is certain"),
      flag("stop_at_contact", &R::stop_at_contact,
           "Stop when the markers of two bodies meet, which the fluid between them prevents as far "
           "as it is resolved; false: say so and go on"),
      number(
          "checkpoint_every", &R::checkpoint_every, between(0, 1e4), "minutes",
          "Interval of the clock on the wall between checkpoints, of which the last two are kept; "
          "0: only at the end and on SIGUSR1"),
      number("patience", &R::patience, between(0, 1e4), "minutes",
             "A rank that has waited so long within one step or one checkpoint, in processor time, "
             "ends "
             "the run: another is stopped, or the disk does not answer; 0: never"),
  };
  return keys;
}

const std::vector<Key<OutputOptions>>& output_keys() {
  using O = OutputOptions;
  static const std::vector<Key<O>> keys = {
      number("every", &O::every, above(0, 1e5), "W^2/nu",
             "Interval between rows of trajectory.csv"),
      number("surfaces_every", &O::surfaces_every, between(0, 1e5), "W^2/nu",
             "Interval between bodies' surfaces in run.h5; 0: none"),
      number("field_every", &O::field_every, between(0, 1e5), "W^2/nu",
             "Interval between fluid fields in run.h5; 0: none"),
  };
  return keys;
}

}  // namespace ductile::drivers
