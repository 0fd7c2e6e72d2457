// Limits of stability of the explicit integrators, predicted and measured:
//     stability_bench [list] [WORD ...] > doc/figures/stability.csv
// runs the cases whose line holds every WORD, one line of CSV each; `list` predicts and runs
// nothing. All of them take about an hour. doc/figures/stability.py draws the result.
//
// A case raises its moduli together until the run fails. Two kinds of run:
//   - box: a capsule drifts with a uniform flow through a small box of fluid, its vertices off by
//     1e-5 at random; it fails if that disturbance grows (tests/drivers/stability_box.hpp);
//   - channel: a scenario as users have it, in Poiseuille flow at Re = 10; it fails if the capsule
//     blows up, or its vertices' velocities change by more than 0.1% of U_max from step to step in
//     the end. (Stable, they change by some 1e-5 U_max; some instabilities end in noise of 0.1
//     U_max and more.)
// Limits are bisected to 2%. `mu` is the largest eigenvalue of K (S S^T/2 + eps) at the measured
// limit: the simple measure of stiffness, for comparison.
#include <fmt/format.h>
#include <petscsys.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "analysis/stability.hpp"
#include "checks/read_case.hpp"
#include "drivers/stability_box.hpp"
#include "ductile/coupling/coupler.hpp"
#include "ductile/surface/mesh.hpp"
#include "ductile/suspension/suspension.hpp"
#include "response.hpp"

namespace {

using namespace ductile;
using drivers::StabilityProblem;

constexpr double accuracy = 1.02;

bool fails_in_channel(const suspension::Plan& plan) {
  constexpr int steps = 3000;
  suspension::Suspension suspension(plan, MPI_COMM_SELF);
  std::vector<double> before;
  double change = 0;
  try {
    for (int n = 0; n < steps; ++n) {
      suspension.step();
      if (n + 2 < steps) continue;
      const std::span<const double> now = suspension.own(0)->velocities();
      change = 0;
      for (std::size_t i = 0; i < before.size(); ++i)
        change += (now[i] - before[i]) * (now[i] - before[i]);
      before.assign(now.begin(), now.end());
    }
  } catch (const coupling::BodyFailure&) {
    return true;
  }
  return !(std::sqrt(3 * change / static_cast<double>(before.size())) < 1e-3 * plan.u_max);
}

/// The scale at which `fails` begins to hold, looked for from `guess`.
double limit(double guess, const std::function<bool(double)>& fails) {
  double stable = 0;
  double unstable = 0;
  for (double scale = guess; stable == 0 || unstable == 0;) {
    if (fails(scale)) {
      unstable = scale;
      scale /= 1.15;
    } else {
      stable = scale;
      scale *= 1.15;
    }
  }
  while (unstable / stable > accuracy) {
    const double middle = std::sqrt(stable * unstable);
    (fails(middle) ? unstable : stable) = middle;
  }
  return std::sqrt(stable * unstable);
}

/// Largest eigenvalue of K (S S^T/2 + eps), by power iteration.
double simple_measure(const StabilityProblem& p) {
  surface::Mesh mesh = test::rest_shape(p);
  surface::place(mesh, p.rotation, {0.3, 0.1, 0.4});
  const membrane::Shell shell(mesh, p.moduli);
  const auto x = shell.create_vec();
  const auto f = shell.create_vec();
  const auto u = shell.create_vec();
  const auto gradient = shell.create_vec();
  std::vector<double> positions;
  for (const Eigen::Vector3d& v : mesh.vertices)
    positions.insert(positions.end(), v.begin(), v.end());
  {
    const membrane::VecArray<double> array(x.get());
    std::copy(positions.begin(), positions.end(), array.data());
  }
  const auto tangent = shell.create_tangent();
  shell.tangent(x.get(), tangent.get());
  const double volume = shell.volume_stiffness(x.get(), gradient.get());
  coupling::MarkerResponse response;
  response.locate(positions);
  std::mt19937 generator(3);
  {
    std::normal_distribution<double> normal;
    const membrane::VecArray<double> array(x.get());
    for (double& number : array.span()) number = normal(generator);
  }
  double eigenvalue = 0;
  for (int n = 0; n < 200; ++n) {
    using membrane::petsc_check;
    petsc_check(MatMult(tangent.get(), x.get(), f.get()));
    double swelling = 0;
    petsc_check(VecDot(gradient.get(), x.get(), &swelling));
    petsc_check(VecAXPY(f.get(), volume * swelling, gradient.get()));
    {
      const membrane::VecArray<const double> force(f.get());
      const membrane::VecArray<double> answer(u.get());
      response.apply(force.span(), answer.span());
      for (std::size_t i = 0; i < force.size(); ++i)
        answer[i] += p.mobility * 3 / (p.tau - 0.5) / shell.vertex_areas()[i / 3] * force[i];
    }
    double work = 0;
    double elastic = 0;
    petsc_check(VecDot(f.get(), u.get(), &work));
    petsc_check(VecDot(f.get(), x.get(), &elastic));
    eigenvalue = work / elastic;
    petsc_check(VecNormalize(u.get(), nullptr));
    petsc_check(VecCopy(u.get(), x.get()));
  }
  return eigenvalue;
}

struct Case {
  std::string group;       // what is raised: shear, bending, volume, mixture
  std::string integrator;  // an explicit one
  StabilityProblem problem;
  std::string scenario;  // of a channel; its `@` is what is raised
  double edge = 1.2;
};

std::string line(const Case& c) {
  const StabilityProblem& p = c.problem;
  const membrane::Moduli& k = p.moduli;
  return fmt::format("{},{},{},{:g},{},{:.3g},{:.3g},{},{:.3g},{:.3g},{:.3g},{},{:g}", c.group,
                     c.scenario.empty() ? "box" : "channel", c.integrator, p.tau, p.shape, p.radius,
                     c.edge, k.law == membrane::StrainLaw::skalak ? "skalak" : "neo-hookean",
                     k.k_s > 0 ? k.k_a / k.k_s : 0, k.k_s > 0 ? k.k_b / k.k_s : 0,
                     k.k_s > 0 ? k.k_v / k.k_s : 0,
                     p.collision == fluid::Collision::bgk ? "bgk" : "trt", p.mobility);
}

class Cases {
 public:
  [[nodiscard]] const std::vector<Case>& all() const { return list_; }

  Cases() {
    for (const double tau : {1.0, 0.9, 0.8, 0.7, 0.6, 0.55}) {
      for (const char* integrator : {euler, adams}) each({.tau = tau, .integrator = integrator});
    }
    for (const double radius : {4.0, 5.5, 10.0, 14.0, 18.0}) each({.radius = radius});
    for (const double radius : {4.0, 12.0}) each({.tau = 0.6, .radius = radius});
    for (const double edge : {0.5, 0.7, 0.9, 1.4}) each({.edge = edge});
    each({.tau = 0.6, .edge = 0.7});
    for (const double tau : {1.0, 0.6}) {
      for (const double mobility : {0.0, 3e-3}) each({.tau = tau, .mobility = mobility});
      each({.tau = tau, .shape = "biconcave"});
      for (const double ratio : {0.0, 0.5, 10.0})
        add("shear", {.tau = tau}, {.k_s = 1, .k_a = ratio});
      add("shear", {.tau = tau}, {.law = membrane::StrainLaw::neo_hookean, .k_s = 1});
      mixtures({.tau = tau});
      mixtures({.tau = tau, .shape = "biconcave"});
    }
    each({.integrator = adams, .shape = "biconcave"});
    mixtures({.integrator = adams});
    for (const double tau : {0.9, 0.7}) each({.tau = tau, .collision = fluid::Collision::trt});
    channels();
  }

 private:
  static constexpr const char* euler = "explicit-euler";
  static constexpr const char* adams = "adams-bashforth";

  struct Common {
    double tau = 1;
    double radius = 7.2;
    double edge = 1.2;
    const char* integrator = euler;
    double mobility = 1e-3;
    const char* shape = "sphere";
    fluid::Collision collision = fluid::Collision::bgk;
  };

  void add(const char* group, const Common& c, const membrane::Moduli& moduli) {
    Case result{group, c.integrator, {}, "", c.edge};
    StabilityProblem& p = result.problem;
    p.shape = c.shape;
    p.radius = c.radius;
    p.frequency = surface::frequency_for_edge(c.radius, c.edge);
    p.rotation = Eigen::AngleAxisd(0.35, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    p.moduli = moduli;
    p.mobility = c.mobility;
    p.tau = c.tau;
    p.collision = c.collision;
    list_.push_back(result);
  }
  // Each modulus alone; the Skalak law with C = 2.
  void each(const Common& c) {
    add("shear", c, {.k_s = 1, .k_a = 2});
    add("bending", c, {.k_b = 1});
    add("volume", c, {.k_v = 1});
  }
  // The paper's bending with a volume modulus that matters as much; and bending as well.
  void mixtures(const Common& c) {
    const double k_b = 2.87e-3 * c.radius * c.radius;
    const double k_v = c.shape == std::string("sphere") ? 2 : 1.2;
    add("mixture", c, {.k_s = 1, .k_a = 2, .k_b = k_b, .k_v = k_v});
    add("mixture", c, {.k_s = 1, .k_a = 2, .k_b = c.tau > 0.8 ? 1.4 : 0.7, .k_v = k_v});
  }

  void channel(const char* group, const std::string& keys, const std::string& raised) {
    list_.push_back(
        {group, "", {}, "[channel]\nlength = 4\n" + keys + "[[body]]\nx = 0.2\n" + raised, 1.2});
  }
  void channels() {
    const std::string laplace = "laplace = @\n";
    for (const char* tau : {"1", "0.8", "0.6"})
      channel("mixture", fmt::format("nodes = 36\n[fluid]\ntau = {}\n", tau), laplace);
    channel("mixture", "nodes = 24\n", laplace);
    channel("mixture", "nodes = 48\n", laplace);
    channel("mixture", "nodes = 36\n[membrane]\nedge = 0.7\n", laplace);
    channel("mixture", "nodes = 36\n[membrane]\nmobility = 0\n", laplace);
    channel("mixture", "nodes = 36\n[membrane]\nintegrator = 'adams-bashforth'\n", laplace);
    channel("mixture", "nodes = 36\n", laplace + "shape = 'biconcave'\n");
    channel("mixture", "nodes = 36\n[membrane]\nlaw = 'neo-hookean'\n", laplace);
    channel("volume", "nodes = 36\n", "laplace = 100\nvolume_modulus = @\n");
    channel("volume", "nodes = 36\n[fluid]\ntau = 0.7\n", "laplace = 100\nvolume_modulus = @\n");
    channel("bending", "nodes = 36\n[fluid]\ntau = 0.7\n[membrane]\nedge = 0.7\n",
            "laplace = 100\nbending = @\n");
  }

  std::vector<Case> list_;
};

std::string with(std::string text, double value) {
  return text.replace(text.find('@'), 1, fmt::format("{:.10g}", value));
}

// A channel's load in what its `@` raises; the rest stays as it is.
double raised_load(const Case& c, const drivers::StabilityLoad& load) {
  return c.group == "volume" ? load.volume : c.group == "bending" ? load.bending : load.total;
}

void run(Case c, bool measure) {
  std::function<bool(double)> fails;
  double unit = 1;  // of what is printed, for a scale of 1
  if (c.scenario.empty()) {
    const membrane::Moduli& k = c.problem.moduli;
    unit = k.k_s > 0 ? k.k_s : (k.k_b > 0 ? k.k_b : k.k_v);
    fails = [&](double scale) {
      return test::fails_in_box(c.problem, membrane::find_scheme(c.integrator), scale, 2000);
    };
  } else {
    const double reference = c.group == "bending" ? 1e-2 : (c.group == "volume" ? 1e4 : 100);
    const drivers::Case given = drivers::parse_case(with(c.scenario, reference), "channel");
    c.problem = drivers::stability_problem(given.plan, 0);
    c.integrator = given.scenario.bodies[0].membrane.integrator;
    c.edge = given.scenario.bodies[0].membrane.edge;
    const membrane::Moduli& k = c.problem.moduli;
    unit = c.group == "bending" ? k.k_b : (c.group == "volume" ? k.k_v : k.k_s);
    fails = [&c, reference](double scale) {
      return fails_in_channel(
          drivers::parse_case(with(c.scenario, reference * scale), "channel").plan);
    };
    // The default volume modulus does not follow the Laplace number.
    if (c.group == "mixture") c.problem.moduli.k_v = 0;
  }
  const drivers::StabilityModel model(c.problem);
  const std::vector<double>& weights = membrane::find_scheme(c.integrator).traits.weights;
  const double predicted = 1 / raised_load(c, model.load(weights));
  const auto weakest = model.weakest(weights);
  double measured = std::nan("");
  if (measure) measured = limit(predicted, fails);
  std::printf("%s,%.4g,%.4g,%.3f,%.3g,%.2f,%d\n", line(c).c_str(), predicted * unit,
              measured * unit, predicted / measured,
              c.group == "volume" && !c.scenario.empty() ? std::nan("")
                                                         : simple_measure(c.problem) * measured,
              weakest.frequency, weakest.degree);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (PetscInitialize(nullptr, nullptr, nullptr, nullptr) != 0) return 1;
  int failed = 0;
  try {
    std::vector<std::string> words(argv + 1, argv + argc);
    const bool measure = std::erase(words, "list") == 0;
    std::printf(
        "raised,run,integrator,tau,shape,radius,edge,law,k_a/k_s,k_b/k_s,k_v/k_s,collision,"
        "mobility,predicted,measured,ratio,mu,frequency,degree\n");
    const Cases cases;
    for (const Case& c : cases.all()) {
      const std::string text = line(c) + c.scenario;
      if (std::all_of(words.begin(), words.end(), [&text](const std::string& word) {
            return text.find(word) != std::string::npos;
          }))
        run(c, measure);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    failed = 1;
  }
  return PetscFinalize() == 0 ? failed : 1;
}
