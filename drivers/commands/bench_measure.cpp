#include "commands/bench_measure.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "checks/read_case.hpp"
#include "ductile/fluid/bench.hpp"
#include "ductile/fluid/d3q19.hpp"
#include "ductile/fluid/fluid.hpp"
#include "ductile/fluid/mpi.hpp"
#include "ductile/instruction_set.hpp"
#include "ductile/suspension/suspension.hpp"
#include "output/json.hpp"
#include "scenario/errors.hpp"
#include "scenario/pairs.hpp"

namespace ductile::drivers {
namespace {

using fluid::mpi_check;

constexpr double seconds_a_repeat = 0.15;  // at least, of each measurement
constexpr int populations = fluid::d3q19::Q;

using enum fluid::Precision;
constexpr std::array<BenchPrecision, 3> precisions = {{{double_precision, double_precision},
                                                       {single_precision, double_precision},
                                                       {single_precision, single_precision}}};

std::string_view name(fluid::Precision precision) {
  return precision == single_precision ? "single" : "double";
}

std::string title(const BenchPrecision& precision) {
  if (precision.storage == precision.arithmetic)
    return fmt::format("{} precision", name(precision.storage));
  return fmt::format("{} storage, {} arithmetic", name(precision.storage),
                     name(precision.arithmetic));
}

// The paper's pair M2 with a mesh of 20480 triangles at 90 nodes.
suspension::Plan pair(int nodes, const BenchPrecision& precision) {
  std::string_view text;
  for (const auto& [name, scenario] : pair_scenarios()) {
    if (name == "M2") text = scenario;
  }
  const auto set = [](std::string key, std::string value) {
    return Override{std::move(key), std::move(value), "bench"};
  };
  return parse_case(
             text, "M2.toml",
             {set("channel.nodes", fmt::format("{}", nodes)), set("membrane.edge", "0.68"),
              set("body.lag.x", "-0.2"), set("fluid.storage", std::string(name(precision.storage))),
              set("fluid.arithmetic", std::string(name(precision.arithmetic)))})
      .plan;
}

fluid::Options channel(int nodes, const BenchPrecision& precision, fluid::Boundary walls) {
  fluid::Options options;
  options.nodes = {nodes, nodes, 6 * nodes};
  options.boundary = {walls, walls, fluid::Boundary::periodic};
  options.tau = 0.9;
  options.force = {0, 0, 1e-6};
  options.storage = precision.storage;
  options.arithmetic = precision.arithmetic;
  return options;
}

// Two boxes as large as those around the pair's capsules.
std::array<fluid::Box, 2> boxes(int nodes) {
  const int across = nodes * 2 / 5 + 6;
  const int begin = (nodes - across) / 2;
  const fluid::Range range = {begin, begin + across};
  const int along = across + 2;
  return {fluid::Box{range, range, {2 * nodes, 2 * nodes + along}},
          fluid::Box{range, range, {3 * nodes, 3 * nodes + along}}};
}

// Times things on some of the ranks while the others wait.
class Bench {
 public:
  Bench(const BenchOptions& options, MPI_Comm comm) : options_(options), comm_(comm) {
    mpi_check(MPI_Comm_rank(comm, &rank_), "MPI_Comm_rank");
    mpi_check(MPI_Comm_size(comm, &ranks_), "MPI_Comm_size");
  }

  BenchTable run(const BenchPrecision& precision);

 private:
  [[nodiscard]] double node_count() const { return 6 * std::pow(options_.nodes, 3); }
  // Seconds for `steps` calls of f, the same on all ranks.
  double seconds(int steps, const std::function<void()>& f) const {
    mpi_check(MPI_Barrier(comm_), "MPI_Barrier");
    double time = MPI_Wtime();
    for (int n = 0; n < steps; ++n) f();
    mpi_check(MPI_Barrier(comm_), "MPI_Barrier");
    time = MPI_Wtime() - time;
    mpi_check(MPI_Bcast(&time, 1, MPI_DOUBLE, 0, comm_), "MPI_Bcast");
    return time;
  }
  // An even number, so that each state of the populations is met as often.
  [[nodiscard]] int enough_steps(const std::function<void()>& f) const {
    const double one = seconds(2, f) / 2;
    return 2 * std::max(1, static_cast<int>(std::ceil(0.5 * seconds_a_repeat / one)));
  }
  [[nodiscard]] double speed(int steps, const std::function<void()>& f) const {
    return node_count() * steps / seconds(steps, f);
  }
  struct Reference {
    std::string name;
    std::function<void()> step;
  };
  void row(BenchTable& table, const std::string& name, int ranks, const std::function<void()>& step,
           const std::function<void()>& ceiling, const Reference& reference = {}) const;

  BenchOptions options_;
  MPI_Comm comm_;
  int rank_ = 0;
  int ranks_ = 1;
};

void Bench::row(BenchTable& table, const std::string& name, int ranks,
                const std::function<void()>& step, const std::function<void()>& ceiling,
                const Reference& reference) const {
  BenchRow row{name, ranks, {}, {}, reference.name, {}};
  const int ceiling_steps = enough_steps(ceiling);
  const int reference_steps = reference.step ? enough_steps(reference.step) : 0;
  const int steps = enough_steps(step);
  for (int n = 0; n < options_.repeats; ++n) {
    const double highest = speed(ceiling_steps, ceiling);
    const double compared = reference.step ? speed(reference_steps, reference.step) : 0;
    row.updates.push_back(speed(steps, step));
    row.fraction.push_back(row.updates.back() / highest);
    if (reference.step) row.relative.push_back(row.updates.back() / compared);
    table.ceiling.push_back(highest);
  }
  table.rows.push_back(std::move(row));
}

// Rows of the fluid alone are compared with the same storage's arithmetic in double, where theirs
// is single.
BenchTable Bench::run(const BenchPrecision& precision) {
  BenchTable table;
  table.precision = precision;
  const int n = options_.nodes;
  const auto double_arithmetic = [&](fluid::Boundary walls) -> Reference {
    if (precision.arithmetic == double_precision) return {};
    const BenchPrecision slower{precision.storage, double_precision};
    const auto other = std::make_shared<fluid::Fluid>(comm_, channel(n, slower, walls));
    return {"double arithmetic", [other] { other->step(); }};
  };
  fluid::Fluid streamed(comm_, channel(n, precision, fluid::Boundary::halfway));
  const auto ceiling = [&] { fluid::stream_only(streamed); };
  {
    fluid::Fluid walls(comm_, channel(n, precision, fluid::Boundary::regularized));
    row(
        table, "fluid, walls on nodes", ranks_, [&] { walls.step(); }, ceiling,
        double_arithmetic(fluid::Boundary::regularized));
  }
  fluid::Fluid fluid(comm_, channel(n, precision, fluid::Boundary::halfway));
  const Reference alone{"the fluid alone", [&] { fluid.step(); }};
  row(table, "fluid, half-way walls", ranks_, alone.step, ceiling,
      double_arithmetic(fluid::Boundary::halfway));
  // Rows for one rank, which works while the others wait, are compared with this.
  const std::string all_ranks = fmt::format("{} ranks", ranks_);
  if (ranks_ > 1) {
    std::optional<fluid::Fluid> one;
    if (rank_ == 0) {
      one.emplace(MPI_COMM_SELF, channel(n, precision, fluid::Boundary::halfway));
    }
    row(table, "fluid, half-way walls", 1,
        [&] {
          if (one) one->step();
        },
        ceiling, {all_ranks, alone.step});
  }
  {
    fluid::Fluid boxed(comm_, channel(n, precision, fluid::Boundary::halfway));
    boxed.place_boxes(boxes(n));
    row(
        table, "fluid, forces in two boxes", ranks_, [&] { boxed.step(); }, ceiling, alone);
  }
  const suspension::Plan plan = pair(n, precision);
  suspension::Suspension all(plan, comm_);
  all.step();
  all.reset_profile();
  row(
      table, "two capsules", ranks_, [&] { all.step(); }, ceiling, alone);
  const coupling::Profile& profile = all.profile();
  table.coupled = gathered(profile, profile.total(), comm_).value_or(RunProfile{});
  if (ranks_ > 1) {
    std::optional<suspension::Suspension> one;
    if (rank_ == 0) one.emplace(plan, MPI_COMM_SELF);
    row(table, "two capsules", 1,
        [&] {
          if (one) one->step();
        },
        ceiling, {all_ranks, [&] { all.step(); }});
  }
  return table;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

const BenchRow& find(const BenchTable& table, std::string_view name, int ranks) {
  return *std::find_if(table.rows.begin(), table.rows.end(),
                       [&](const BenchRow& row) { return row.name == name && row.ranks == ranks; });
}

// Seconds of the coupler's parts in a step.
double seconds(const coupling::Profile& profile, std::initializer_list<coupling::Part> parts) {
  double sum = 0;
  for (const coupling::Part part : parts) sum += profile[part];
  return sum / static_cast<double>(profile.steps);
}

// What a pair of bodies with these keys costs on this rank in a step.
struct PairTimes {
  double boxes = 0;    // reading and updating velocities, a node of their boxes
  double markers = 0;  // all that is done with a marker
};
PairTimes time_pair(const std::string& keys, int repeats) {
  const std::string body = "[[body]]\n" + keys;
  const Case given = parse_case("channel.nodes = 36\nchannel.length = 6\n" + body +
                                    "x = 0.2\nz = 0.6\n" + body + "x = -0.2\nz = -0.6\n",
                                "bench.toml");
  suspension::Suspension pair(given.plan, MPI_COMM_SELF);
  for (int n = 0; n < 20; ++n) pair.step();
  const suspension::BodyPlan& one = given.plan.bodies.front();
  const auto markers = static_cast<double>(2 * surface::vertex_count(one.frequency));
  const BoxSize box = box_around(one);
  const double nodes = 2 * box.rows * box.length;
  std::vector<double> node_times;
  std::vector<double> marker_times;
  for (int n = 0; n < repeats; ++n) {
    pair.reset_profile();
    for (int step = 0; step < 60; ++step) pair.step();
    using enum coupling::Part;
    node_times.push_back(seconds(pair.profile(), {coupling::Part::boxes}) / nodes);
    marker_times.push_back(
        seconds(pair.profile(), {locating, interpolation, bodies, spreading, exchange}) / markers);
  }
  return {median(node_times), median(marker_times)};
}

// Seconds that a step of the fluid takes longer by boxes in which forces may act: of a row of nodes
// that meets one, and of a node. Those around two bodies have short rows, the whole channel none
// but long ones.
void time_boxes(BodyCosts& costs, int repeats) {
  constexpr int n = 36;
  constexpr int steps = 30;
  const std::array<std::vector<fluid::Box>, 3> cases = {
      {{}, {boxes(n)[0], boxes(n)[1]}, {{{{0, n}, {0, n}, {0, 6 * n}}}}}};
  std::vector<fluid::Fluid> fluids;
  for (const std::vector<fluid::Box>& placed : cases) {
    fluids.emplace_back(MPI_COMM_SELF, channel(n, precisions.back(), fluid::Boundary::halfway));
    fluids.back().place_boxes(placed);
  }
  std::array<std::vector<double>, 3> times;
  for (int r = 0; r <= repeats; ++r) {
    for (std::size_t c = 0; c < fluids.size(); ++c) {
      const double begin = MPI_Wtime();
      for (int step = 0; step < steps; ++step) fluids[c].step();
      if (r > 0) times[c].push_back((MPI_Wtime() - begin) / steps);  // the first warms up
    }
  }
  const double alone = median(times[0]);
  const fluid::Box& box = cases[1].front();
  const double rows = 2.0 * box[0].size() * box[1].size();
  costs.node = std::max(0.0, (median(times[2]) - alone) / (6.0 * n * n * n));
  costs.row = std::max(0.0, (median(times[1]) - alone - costs.node * rows * box[2].size()) / rows);
}

BodyCosts measure_bodies(int repeats) {
  constexpr double soft = 100;
  constexpr double stiff = 10000;
  const auto laplace = [](double la) { return fmt::format("laplace = {}\n", la); };
  const auto root_of_k_s = [](double la) {
    return std::sqrt(suspension::Units(18, 1.0 / 6, {}).lattice_shear_modulus(la, 7.2));
  };
  const std::string implicit = "integrator = \"implicit\"\n";
  const PairTimes capsules = time_pair(laplace(soft), repeats);
  const PairTimes rigid = time_pair("kind = \"rigid\"\n", repeats);       // five rounds
  const PairTimes solved = time_pair(laplace(soft) + implicit, repeats);  // two
  const PairTimes solved_stiff = time_pair(laplace(stiff) + implicit, repeats);
  BodyCosts costs;
  costs.node_update = std::max(0.0, (rigid.boxes - solved.boxes) / 3);
  costs.node_read = std::max(0.0, solved.boxes - 2 * costs.node_update);
  costs.marker = capsules.markers;
  costs.marker_pass = rigid.markers / 6;
  costs.stiff = std::max(
      0.0, (solved_stiff.markers - solved.markers) / (root_of_k_s(stiff) - root_of_k_s(soft)));
  costs.implicit = std::max(0.0, solved.markers - costs.stiff * root_of_k_s(soft));
  time_boxes(costs, repeats);
  return costs;
}

}  // namespace

BenchResult measure(const BenchOptions& options, MPI_Comm comm) {
  int ranks = 1;
  mpi_check(MPI_Comm_size(comm, &ranks), "MPI_Comm_size");
  if (ranks > 6 * options.nodes) {
    throw InputError(fmt::format("--nodes {}: {} ranks cannot share {} planes of nodes: use fewer",
                                 options.nodes, ranks, 6 * options.nodes));
  }
  // The ceiling's, the reference and what is measured, and a little more; with several ranks also
  // the one that a rank has to itself.
  const double fluids = ranks > 1 ? 4.4 : 3.3;
  const double bytes = fluids * populations * sizeof(double) * 6 * std::pow(options.nodes, 3);
  double memory =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  mpi_check(MPI_Bcast(&memory, 1, MPI_DOUBLE, 0, comm), "MPI_Bcast");
  if (bytes > 0.9 * memory) {
    throw InputError(fmt::format(
        "--nodes {}: the fluids of {} x {} x {} nodes take {:.1f} GB, this machine has "
        "{:.1f}: give fewer nodes",
        options.nodes, options.nodes, options.nodes, 6 * options.nodes, bytes / 1e9, memory / 1e9));
  }
  BenchResult result;
  result.nodes = {options.nodes, options.nodes, 6 * options.nodes};
  result.ranks = ranks;
  result.cores = core_count();
  result.instruction_set = name(best_instruction_set());
  const suspension::Plan plan = pair(options.nodes, precisions.front());
  result.triangles = static_cast<int>(surface::triangle_count(plan.bodies.front().frequency));
  Bench bench(options, comm);
  for (const BenchPrecision& precision : precisions) result.tables.push_back(bench.run(precision));
  // On one rank, while the others wait.
  int rank = 0;
  mpi_check(MPI_Comm_rank(comm, &rank), "MPI_Comm_rank");
  if (rank == 0) {
    result.bodies = measure_bodies(options.repeats);
  }
  mpi_check(MPI_Barrier(comm), "MPI_Barrier");
  return result;
}

std::string table(const BenchResult& result) {
  std::string text = fmt::format(
      "{} x {} x {} nodes, {} rank{} on {} core{}, fluid kernel for {}, capsules of {} triangles\n"
      "speeds in million updates a second and shares of the ceiling (the fluid's loads and stores\n"
      "without its arithmetic): medians of {} repeats, each in turn with what it is compared "
      "with\n",
      result.nodes[0], result.nodes[1], result.nodes[2], result.ranks, result.ranks == 1 ? "" : "s",
      result.cores, result.cores == 1 ? "" : "s", result.instruction_set, result.triangles,
      result.tables.front().rows.front().updates.size());
  for (const BenchTable& t : result.tables) {
    const double bytes = 2 * populations * (t.precision.storage == single_precision ? 4 : 8);
    const double ceiling = median(t.ceiling);
    text += fmt::format("\n{:<34} {:>5} {:>8} {:>8}\n", title(t.precision), "ranks", "speed",
                        "ceiling");
    text += fmt::format("{:<34} {:>5} {:>8.1f} {:>8}   {:.1f} GB/s\n", "ceiling", result.ranks,
                        ceiling / 1e6, "", ceiling * bytes / 1e9);
    for (const BenchRow& row : t.rows) {
      text += fmt::format("{:<34} {:>5} {:>8.1f} {:>7.1f}%", row.name, row.ranks,
                          median(row.updates) / 1e6, 100 * median(row.fraction));
      if (!row.relative.empty() && row.ranks == result.ranks) {
        const double relative = median(row.relative);
        text += relative < 1 ? fmt::format("   {:.1f}% of {}", 100 * relative, row.reference)
                             : fmt::format("   {:.2f} times {}", relative, row.reference);
      } else if (!row.relative.empty()) {
        text +=
            fmt::format("   {} are {:.2f} times as fast", row.reference, 1 / median(row.relative));
      }
      text += '\n';
    }
  }
  const BodyCosts& b = result.bodies;
  text += fmt::format(
      "\nbodies, microseconds of one core in a step: {:.2f} a vertex of an explicit capsule, "
      "{:.2f} "
      "a\nvertex of an implicit one and {:.2f} more times the root of k_s, {:.2f} a marker of a "
      "rigid body\nin each of its rounds\n",
      1e6 * b.marker, 1e6 * b.implicit, 1e6 * b.stiff, 1e6 * b.marker_pass);
  for (const BenchTable& t : result.tables) {
    text +=
        fmt::format("\nthe step with two capsules, {}:\n{}", title(t.precision), table(t.coupled));
  }
  return text;
}

std::string json(const BenchResult& result) {
  Json json;
  json.open('{');
  json.open('[', "nodes");
  for (const int n : result.nodes) json.add("", n);
  json.close(']');
  json.add("ranks", result.ranks);
  json.add("cores", result.cores);
  json.add("kernel", result.instruction_set);
  json.add("triangles", result.triangles);
  json.open('{', "seconds_of_bodies");
  json.add("row", result.bodies.row);
  json.add("node", result.bodies.node);
  json.add("node_read", result.bodies.node_read);
  json.add("node_update", result.bodies.node_update);
  json.add("marker", result.bodies.marker);
  json.add("marker_pass", result.bodies.marker_pass);
  json.add("implicit", result.bodies.implicit);
  json.add("stiff", result.bodies.stiff);
  json.close('}');
  json.open('[', "tables");
  for (const BenchTable& t : result.tables) {
    json.open('{');
    json.add("storage", name(t.precision.storage));
    json.add("arithmetic", name(t.precision.arithmetic));
    json.add("ceiling", std::span<const double>(t.ceiling));
    json.open('[', "rows");
    for (const BenchRow& row : t.rows) {
      json.open('{');
      json.add("name", row.name);
      json.add("ranks", row.ranks);
      json.add("updates_per_second", std::span<const double>(row.updates));
      json.add("fraction_of_ceiling", std::span<const double>(row.fraction));
      json.add("median_fraction", median(row.fraction));
      if (!row.relative.empty()) {
        json.add("reference", row.reference);
        json.add("fraction_of_reference", std::span<const double>(row.relative));
        json.add("median_of_reference", median(row.relative));
      }
      json.close('}');
    }
    json.close(']');
    json.open('{', "two_capsules");
    add_profile(json, t.coupled);
    json.close('}');
    json.close('}');
  }
  json.close(']');
  json.close('}');
  return json.text();
}

bool is_representative(const BenchResult& result) {
  return result.nodes[0] == BenchOptions{}.nodes && result.ranks <= result.cores;
}

KnownSpeed speed_of(const BenchResult& result) {
  KnownSpeed speed;
  speed.ranks = result.ranks;
  speed.bodies = result.bodies;
  for (const BenchTable& table : result.tables) {
    const auto updates = [&table](int ranks) {
      return median(find(table, "fluid, half-way walls", ranks).updates);
    };
    fluid::Options options;
    options.storage = table.precision.storage;
    options.arithmetic = table.precision.arithmetic;
    speed.fluid.of(options) = updates(result.ranks);
    speed.alone.of(options) = updates(1);
  }
  return speed;
}

}  // namespace ductile::drivers
