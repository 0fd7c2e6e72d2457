#include "output/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "output/json.hpp"

namespace ductile::drivers {
namespace {

/// Positions of all bodies at `time`, which lies within the samples.
std::vector<Eigen::Vector3d> positions_at(const std::vector<suspension::Sample>& samples,
                                          double time) {
  auto after =
      std::lower_bound(samples.begin(), samples.end(), time,
                       [](const suspension::Sample& sample, double t) { return sample.time < t; });
  if (after == samples.end()) --after;
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t b = 0; b < after->bodies.size(); ++b) {
    Eigen::Vector3d position = after->bodies[b].position();
    if (after->time > time && after != samples.begin()) {
      const suspension::Sample& before = *(after - 1);
      const double weight = (time - before.time) / (after->time - before.time);
      position = (1 - weight) * before.bodies[b].position() + weight * position;
    }
    positions.push_back(position);
  }
  return positions;
}

membrane::SolveStatistics solver(const Contender& contender) {
  membrane::SolveStatistics all;
  for (const BodySummary& body : contender.summary.bodies) {
    if (!body.capsule) continue;
    const membrane::SolveStatistics& one = body.capsule->solver;
    all.solves += one.solves;
    all.newton_iterations += one.newton_iterations;
    all.krylov_iterations += one.krylov_iterations;
    all.tangents += one.tangents;
    all.step_cuts += one.step_cuts;
  }
  return all;
}

std::int64_t capsules(const Contender& contender) {
  return std::ranges::count_if(contender.summary.bodies,
                               [](const BodySummary& body) { return body.capsule.has_value(); });
}

/// A count of all capsules, for one capsule and step.
double per_step(const Contender& contender, std::int64_t count) {
  return static_cast<double>(count) /
         static_cast<double>(contender.summary.steps * capsules(contender));
}

double volume_error(const Contender& contender) {
  double largest = 0;
  for (const BodySummary& body : contender.summary.bodies) {
    if (body.capsule) largest = std::max(largest, body.capsule->volume_error_max);
  }
  return largest;
}

std::string_view bodies_part(const Contender& contender) {
  const bool all_capsules =
      capsules(contender) == static_cast<std::int64_t>(contender.summary.bodies.size());
  return all_capsules ? "membrane" : "bodies";
}

constexpr const char* none = "-";

/// A column for each contender, built row by row.
class Columns {
 public:
  explicit Columns(const std::vector<Contender>& contenders) : contenders_(contenders) {}

  void heading(std::string text) { rows_.push_back({std::move(text), {}}); }
  void add(std::string label, const std::function<std::string(const Contender&)>& cell) {
    rows_.push_back({std::move(label), {}});
    for (const Contender& contender : contenders_) rows_.back().cells.push_back(cell(contender));
  }
  void add_difference(std::string label,
                      const std::function<std::string(const Difference&)>& cell) {
    const Contender& first = contenders_.front();
    add(std::move(label), [&](const Contender& c) -> std::string {
      if (&c == &first) return none;
      const Difference apart = difference(first.samples, c.samples);
      return apart.until > 0 ? cell(apart) : none;
    });
  }
  void add_cost(std::string label, double StepCost::*part) {
    add(std::move(label), [part](const Contender& c) {
      const auto cost = step_cost(c.summary.profile.value());
      return cost ? fmt::format("{:.4g}", *cost.*part) : none;
    });
  }
  /// The count of all capsules together, or the mean over capsules and steps.
  void add_count(std::string label, std::int64_t membrane::SolveStatistics::*count, bool mean) {
    add(std::move(label), [=](const Contender& c) -> std::string {
      const std::int64_t n = solver(c).*count;
      if (n == 0) return none;
      return mean ? fmt::format("{:.2f}", per_step(c, n)) : fmt::format("{}", n);
    });
  }

  [[nodiscard]] std::string text() const {
    // A heading runs on over the cells, of which it has none.
    std::size_t label_width = 0;
    std::vector<std::size_t> widths(contenders_.size(), 0);
    for (const Row& row : rows_) {
      if (!row.cells.empty()) label_width = std::max(label_width, row.label.size());
      for (std::size_t c = 0; c < row.cells.size(); ++c)
        widths[c] = std::max(widths[c], row.cells[c].size());
    }
    std::string text;
    for (const Row& row : rows_) {
      text += row.cells.empty() ? row.label : fmt::format("{:<{}}", row.label, label_width);
      for (std::size_t c = 0; c < row.cells.size(); ++c)
        text += fmt::format("  {:>{}}", row.cells[c], widths[c]);
      text += '\n';
    }
    return text;
  }

 private:
  struct Row {
    std::string label;
    std::vector<std::string> cells;
  };
  const std::vector<Contender>& contenders_;
  std::vector<Row> rows_;
};

void add_outcome(Columns& columns, const Summary& first) {
  columns.add("", [](const Contender& c) { return c.integrator; });
  columns.add("outcome",
              [](const Contender& c) { return std::string(to_string(c.summary.status)); });
  if (first.verdict) {
    columns.add("verdict", [](const Contender& c) {
      return std::string(c.summary.blow_up ? none : to_string(c.summary.verdict->pair_class));
    });
  }
  columns.add("time at the end [W^2/nu]",
              [](const Contender& c) { return fmt::format("{:.4g}", c.summary.time); });
  columns.add("steps", [](const Contender& c) { return fmt::format("{}", c.summary.steps); });
  columns.heading("position in the last row [W]");
  for (std::size_t b = 0; b < first.bodies.size(); ++b) {
    columns.add("  " + first.bodies[b].name, [b](const Contender& c) {
      // Digits that are not shown leave no sign behind.
      const Eigen::Vector3d x = (c.summary.bodies[b].position * 1e4).array().round() / 1e4 + 0.0;
      return fmt::format("({:.4f}, {:.4f}, {:.3f})", x.x(), x.y(), x.z());
    });
  }
  if (first.dz) {
    columns.add("  dz",
                [](const Contender& c) { return fmt::format("{:.4f}", c.summary.dz.value()); });
  }
}

void add_differences(Columns& columns, const Contender& first) {
  columns.heading(fmt::format("largest difference to {} [W]", first.integrator));
  columns.add_difference("  in x",
                         [](const Difference& d) { return fmt::format("{:.2g}", d.largest().x); });
  columns.add_difference("  in y",
                         [](const Difference& d) { return fmt::format("{:.2g}", d.largest().y); });
  if (first.summary.dz) {
    columns.add_difference("  in dz",
                           [](const Difference& d) { return fmt::format("{:.2g}", d.dz.value()); });
  }
  columns.add_difference("  until [W^2/nu]",
                         [](const Difference& d) { return fmt::format("{:.4g}", d.until); });
}

void add_membranes(Columns& columns, const Summary& first) {
  columns.add("largest volume error",
              [](const Contender& c) { return fmt::format("{:.2g}", volume_error(c)); });
  columns.heading("strain energy in the last row [k_s a^2]");
  for (std::size_t b = 0; b < first.bodies.size(); ++b) {
    if (!first.bodies[b].capsule) continue;
    columns.add("  " + first.bodies[b].name, [b](const Contender& c) {
      return fmt::format("{:.4g}", c.summary.bodies[b].capsule.value().strain_energy);
    });
  }
}

void add_costs(Columns& columns, const Contender& first) {
  columns.heading("cost of a step [ms]");
  columns.add_cost("  fluid", &StepCost::fluid);
  columns.add_cost("  interpolation", &StepCost::interpolation);
  columns.add_cost(fmt::format("  {}", bodies_part(first)), &StepCost::bodies);
  columns.add_cost("  spreading", &StepCost::spreading);
  columns.add_cost("  rest", &StepCost::rest);
  columns.add_cost("  all", &StepCost::step);
  const auto unit = step_cost(first.summary.profile.value());
  columns.add(fmt::format("  all, of {}", first.integrator), [&](const Contender& c) {
    const auto cost = step_cost(c.summary.profile.value());
    return cost && unit ? fmt::format("{:.2f}", cost->step / unit->step) : none;
  });
  columns.heading("iterations of a capsule and step");
  columns.add_count("  Newton", &membrane::SolveStatistics::newton_iterations, true);
  columns.add_count("  Krylov", &membrane::SolveStatistics::krylov_iterations, true);
  columns.add_count("tangents assembled", &membrane::SolveStatistics::tangents, false);
  columns.add_count("steps cut", &membrane::SolveStatistics::step_cuts, false);
  columns.add("wall time [s]",
              [](const Contender& c) { return fmt::format("{:.1f}", c.summary.wall_time); });
}

}  // namespace

Difference::Body Difference::largest() const {
  Body all;
  for (const Body& body : bodies) all = {std::max(all.x, body.x), std::max(all.y, body.y)};
  return all;
}

Difference difference(const std::vector<suspension::Sample>& first,
                      const std::vector<suspension::Sample>& second) {
  Difference result;
  result.until = std::min(first.back().time, second.back().time);
  result.bodies.resize(first.front().bodies.size());
  if (result.bodies.size() == 2) result.dz = 0;
  std::vector<double> times;
  for (const suspension::Sample& sample : second) {
    if (sample.time < result.until) times.push_back(sample.time);
  }
  times.push_back(result.until);
  for (const double time : times) {
    const auto a = positions_at(first, time);
    const auto b = positions_at(second, time);
    for (std::size_t n = 0; n < result.bodies.size(); ++n) {
      result.bodies[n].x = std::max(result.bodies[n].x, std::abs(a[n].x() - b[n].x()));
      result.bodies[n].y = std::max(result.bodies[n].y, std::abs(a[n].y() - b[n].y()));
    }
    if (result.dz) {
      const double apart = (a[0].z() - a[1].z()) - (b[0].z() - b[1].z());
      result.dz = std::max(*result.dz, std::abs(apart));
    }
  }
  return result;
}

std::optional<StepCost> step_cost(const RunProfile& profile) {
  if (profile.steps == 0 || profile.ranks.empty()) return std::nullopt;
  using coupling::Part;
  const double unit = 1e3 / static_cast<double>(profile.steps);
  StepCost cost;
  cost.fluid = unit * profile.largest(Part::fluid);
  cost.interpolation = unit * profile.largest(Part::interpolation);
  cost.bodies = unit * profile.largest(Part::bodies);
  cost.spreading = unit * profile.largest(Part::spreading);
  cost.step = unit * profile.longest_step();
  cost.rest =
      std::max(0.0, cost.step - (cost.fluid + cost.interpolation + cost.bodies + cost.spreading));
  return cost;
}

std::string table(const std::vector<Contender>& contenders) {
  const Contender& first = contenders.front();
  Columns columns(contenders);
  add_outcome(columns, first.summary);
  add_differences(columns, first);
  add_membranes(columns, first.summary);
  add_costs(columns, first);
  std::string text = columns.text();
  for (const Contender& c : contenders) {
    if (const auto& blow_up = c.summary.blow_up) {
      text += fmt::format("{}: {} blew up at step {}: {}\n", c.integrator, blow_up->who(),
                          blow_up->step, blow_up->reason);
    }
    for (const std::string& warning : c.summary.warnings)
      text += fmt::format("{}: warning: {}\n", c.integrator, warning);
  }
  return text;
}

std::string to_json(const std::vector<Contender>& contenders) {
  const Contender& first = contenders.front();
  Json json;
  json.open('{');
  json.add("scenario", first.summary.scenario);
  json.add("reference", first.integrator);
  json.add("ranks", first.summary.ranks);
  json.add("bodies_part", bodies_part(first));
  json.open('[', "runs");
  for (const Contender& c : contenders) {
    const Summary& s = c.summary;
    json.open('{');
    json.add("integrator", c.integrator);
    json.add("directory", c.integrator);
    json.add("status", to_string(s.status));
    if (s.blow_up) add_blow_up(json, *s.blow_up);
    if (s.verdict) json.add("verdict", to_string(s.verdict->pair_class));
    json.add("time_W2_over_nu", s.time);
    json.add("steps", s.steps);
    json.add("wall_time_s", s.wall_time);
    const Difference apart = difference(first.samples, c.samples);
    json.open('{', "difference");
    json.add("until_W2_over_nu", apart.until);
    json.add("x_W", apart.largest().x);
    json.add("y_W", apart.largest().y);
    if (apart.dz) json.add("dz_W", apart.dz);
    json.close('}');
    if (s.dz) json.add("dz_W", s.dz);
    json.open('[', "bodies");
    for (std::size_t b = 0; b < s.bodies.size(); ++b) {
      const BodySummary& body = s.bodies[b];
      json.open('{');
      json.add("name", body.name);
      json.add("position_W", body.position);
      json.add("x_difference_W", apart.bodies[b].x);
      json.add("y_difference_W", apart.bodies[b].y);
      if (body.capsule) {
        json.add("volume_error_max", body.capsule->volume_error_max);
        json.add("strain_energy_over_ks_a2", body.capsule->strain_energy);
        add_solver(json, body.capsule->solver, s.steps);
      }
      json.close('}');
    }
    json.close(']');
    if (const auto cost = step_cost(s.profile.value())) {
      json.open('{', "cost_per_step_ms");
      json.add("fluid", cost->fluid);
      json.add("interpolation", cost->interpolation);
      json.add("bodies", cost->bodies);
      json.add("spreading", cost->spreading);
      json.add("rest", cost->rest);
      json.add("step", cost->step);
      json.close('}');
    }
    json.close('}');
  }
  json.close(']');
  json.close('}');
  return json.text();
}

}  // namespace ductile::drivers
