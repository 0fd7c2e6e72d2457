#include "analysis/stability.hpp"

#include <mpi.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "ductile/coupling/coupler.hpp"
#include "ductile/membrane/integrator.hpp"
#include "ductile/membrane/petsc.hpp"
#include "ductile/surface/mesh.hpp"
#include "ductile/surface/shape.hpp"

namespace ductile::drivers {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;
using std::numbers::pi;

constexpr double largest_radius = 20;
constexpr double box_margin = 5;      // about the mesh, lattice spacings
constexpr double small_force = 1e-5;  // lattice units; the fluid answers linearly
constexpr double largest_wave = 1.3;  // wave number of the harmonics
constexpr int longest_memory = 400;   // steps
constexpr int frequency_count = 500;
// Radians in a step. Slower swings are resolved by the step and damped by viscosity, however
// little; what the box says of them is spoilt by its images. N and L swing with sound, T without.
constexpr double slowest = 0.2;
constexpr double slowest_of_sound = 0.6;

double frequency(int i) {
  return slowest + (pi - slowest) * i / (frequency_count - 1);
}

int box_nodes(double reach) {
  return 2 * static_cast<int>(std::ceil(reach + box_margin));
}

// sum_j a_j z^-j
Complex transform(std::span<const double> a, Complex z) {
  Complex sum = 0;
  for (std::size_t j = a.size(); j-- > 0;) sum = sum / z + a[j];
  return sum;
}

membrane::Moduli only(membrane::Moduli moduli, std::size_t part) {
  if (part != 0) moduli.k_s = moduli.k_a = 0;
  if (part != 1) moduli.k_b = 0;
  if (part != 2) moduli.k_v = 0;
  return moduli;
}

bool any(const membrane::Moduli& moduli) {
  return moduli.k_s > 0 || moduli.k_a > 0 || moduli.k_b > 0 || moduli.k_v > 0;
}

// The stiffness K = d2E/dx2 of a shell in its reference shape.
class Stiffness {
 public:
  Stiffness(const surface::Mesh& mesh, const membrane::Moduli& moduli) {
    const membrane::Shell shell(mesh, moduli);
    tangent_ = shell.create_tangent();
    gradient_ = shell.create_vec();
    in_ = shell.create_vec();
    out_ = shell.create_vec();
    {
      const membrane::VecArray<double> x(in_.get());
      for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
        Vector3d::Map(&x[3 * i]) = mesh.vertices[i];
    }
    shell.tangent(in_.get(), tangent_.get());
    volume_ = shell.volume_stiffness(in_.get(), gradient_.get());
  }

  [[nodiscard]] VectorXd operator*(const VectorXd& displacement) const {
    {
      const membrane::VecArray<double> x(in_.get());
      std::copy(displacement.begin(), displacement.end(), x.data());
    }
    membrane::petsc_check(MatMult(tangent_.get(), in_.get(), out_.get()));
    double swelling = 0;
    membrane::petsc_check(VecDot(gradient_.get(), in_.get(), &swelling));
    membrane::petsc_check(VecAXPY(out_.get(), volume_ * swelling, gradient_.get()));
    const membrane::VecArray<const double> y(out_.get());
    return VectorXd::Map(y.data(), displacement.size());
  }

 private:
  membrane::MatPtr tangent_;
  membrane::VecPtr gradient_;  // dV/dx
  double volume_ = 0;          // k_v/V0
  membrane::VecPtr in_;
  membrane::VecPtr out_;
};

// A mesh held still in a box of fluid at rest: forces at its vertices, and the fluid's velocity
// there.
class Bath final : public coupling::Body {
 public:
  Bath(const StabilityProblem& problem, const surface::Mesh& mesh)
      : fluid_(MPI_COMM_SELF, options(problem, mesh)),
        positions_(placed(mesh, (fluid_.options().nodes[0] - 1) / 2.0)),
        force_(VectorXd::Zero(static_cast<Index>(positions_.size()))),
        velocity_(force_),
        coupler_(fluid_, {{0, this}}, 1) {}

  /// One time step; the velocity at its beginning, half of the force in.
  const VectorXd& step(const VectorXd& force) {
    force_ = force;
    coupler_.step();
    return velocity_;
  }

  [[nodiscard]] std::size_t marker_count() const override { return positions_.size() / 3; }
  [[nodiscard]] std::span<const double> positions() const override { return positions_; }
  [[nodiscard]] int corrections() const override { return 0; }
  void predict_force(std::span<double> force) override {
    std::copy(force_.begin(), force_.end(), force.begin());
  }
  void correct_force(std::span<const double> /*velocity*/, const coupling::Response& /*response*/,
                     std::span<double> /*increment*/) override {}
  void advance(std::span<const double> velocity) override {
    std::copy(velocity.begin(), velocity.end(), velocity_.begin());
  }

 private:
  static fluid::Options options(const StabilityProblem& problem, const surface::Mesh& mesh) {
    double reach = 0;
    for (const Vector3d& v : mesh.vertices) reach = std::max(reach, v.norm());
    const int nodes = box_nodes(reach);
    fluid::Options options;
    options.nodes = {nodes, nodes, nodes};
    options.tau = problem.tau;
    options.collision = problem.collision;
    options.magic = problem.magic;
    return options;
  }

  // Centred half-way between nodes, so that the lattice's symmetries map the box onto itself.
  static std::vector<double> placed(const surface::Mesh& mesh, double centre) {
    std::vector<double> positions;
    for (const Vector3d& v : mesh.vertices) {
      for (const double x : v) positions.push_back(x + centre);
    }
    return positions;
  }

  fluid::Fluid fluid_;
  std::vector<double> positions_;
  VectorXd force_;
  VectorXd velocity_;
  coupling::Coupler coupler_;
};

// Area of each vertex, three times each.
VectorXd masses(const surface::Mesh& mesh) {
  const std::vector<double> areas = surface::vertex_areas(mesh);
  VectorXd mass(static_cast<Index>(3 * areas.size()));
  for (std::size_t i = 0; i < areas.size(); ++i)
    mass.segment<3>(static_cast<Index>(3 * i)).setConstant(areas[i]);
  return mass;
}

void normalise(VectorXd& field, const VectorXd& mass) {
  const double square = field.dot(mass.cwiseProduct(field));
  if (square > 0) field /= std::sqrt(square);
}

// P_l(t) and its derivative for l = 0, 1, ...
void legendre(double t, std::vector<double>& p, std::vector<double>& derivative) {
  for (std::size_t l = 0; l < p.size(); ++l) {
    const auto n = static_cast<double>(l);
    p[l] = l == 0 ? 1 : (l == 1 ? t : ((2 * n - 1) * t * p[l - 1] - (n - 1) * p[l - 2]) / n);
    derivative[l] = l == 0 ? 0 : (l == 1 ? 1 : derivative[l - 2] + (2 * n - 1) * p[l - 1]);
  }
}

surface::Mesh mesh_of(const StabilityProblem& problem) {
  surface::Mesh mesh = surface::make_shape(problem.shape, problem.radius)
                           ->mesh(problem.frequency, -problem.retraction);
  surface::place(mesh, problem.rotation, Vector3d::Zero());
  return mesh;
}

// A smaller capsule with the same edges; the limits of larger ones are within 2%.
StabilityProblem of_bearable_size(StabilityProblem problem) {
  if (problem.radius <= largest_radius) return problem;
  const int frequency =
      std::max(2, static_cast<int>(problem.frequency * largest_radius / problem.radius));
  const double ratio = static_cast<double>(frequency) / problem.frequency;
  problem.frequency = frequency;
  problem.radius *= ratio;
  problem.retraction *= ratio;
  problem.moduli.k_v *= ratio;  // k_v A/V is kept
  return problem;
}

// A force on the scale of a few spacings is forgotten at a rate of about nu.
int steps_of_memory(double tau) {
  return static_cast<int>(
      std::min<double>(longest_memory, 40 + 2 / suspension::lattice_viscosity(tau)));
}

// Largest eigenvalue of K (G(-1) + eps): G(-1) is the fluid's answer to forces that change sign in
// every step, and the power iteration goes on while the fluid does.
double alternating(const StabilityProblem& problem, const membrane::Moduli& moduli, double slip,
                   int steps) {
  if (moduli.k_s == 0 && moduli.k_a == 0 && moduli.k_b == 0) return 0;
  const surface::Mesh mesh = mesh_of(problem);
  const VectorXd mobility = slip * masses(mesh).cwiseInverse();
  const Stiffness stiffness(mesh, moduli);
  std::mt19937 random(1);  // NOLINT(cert-msc*): the same every time
  VectorXd x(mobility.size());
  for (Index i = 0; i < x.size(); i += 3) {
    Vector3d v;
    for (double& y : v)
      y = static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 0.5;
    x.segment<3>(i) = problem.rotation * v;
  }
  Bath bath(problem, mesh);
  double eigenvalue = 0;
  for (int n = 0; n < steps; ++n) {
    const VectorXd force = stiffness * x;
    const double scale = (n % 2 == 0 ? 1 : -1) * small_force / force.cwiseAbs().maxCoeff();
    const VectorXd answer = bath.step(scale * force) / scale + mobility.cwiseProduct(force);
    eigenvalue = force.dot(answer) / force.dot(x);
    x = answer.normalized();
  }
  return eigenvalue;
}

}  // namespace

bool StabilityProblem::operator==(const StabilityProblem& o) const {
  const membrane::Moduli& k = moduli;
  const membrane::Moduli& l = o.moduli;
  return shape == o.shape && radius == o.radius && retraction == o.retraction &&
         frequency == o.frequency && rotation == o.rotation && k.law == l.law && k.k_s == l.k_s &&
         k.k_a == l.k_a && k.k_b == l.k_b && k.k_v == l.k_v && mobility == o.mobility &&
         tau == o.tau && collision == o.collision && magic == o.magic;
}

StabilityProblem stability_problem(const suspension::Plan& plan, std::size_t index) {
  const suspension::BodyPlan& body = plan.bodies[index];
  StabilityProblem problem;
  problem.shape = body.shape->name();
  problem.radius = body.shape->radius();
  problem.retraction = body.retraction();
  problem.frequency = body.frequency;
  problem.rotation = body.rotation;
  problem.moduli = body.capsule()->moduli;
  problem.mobility = body.capsule()->mobility;
  problem.tau = plan.fluid.tau;
  problem.collision = plan.fluid.collision;
  problem.magic = plan.fluid.magic;
  return problem;
}

StabilityModel::StabilityModel(const StabilityProblem& given) {
  const StabilityProblem problem = of_bearable_size(given);
  const double nu = suspension::lattice_viscosity(problem.tau);
  slip_ = problem.mobility / nu;
  const int memory = steps_of_memory(problem.tau);
  measure_breathing(problem, memory);
  measure_harmonics(problem, memory);
  for (const Part part : {shear, bending})
    alternating_[part] = alternating(problem, only(problem.moduli, part), slip_, memory);
  alternating_total_ = alternating_[shear] > 0 && alternating_[bending] > 0
                           ? alternating(problem, problem.moduli, slip_, memory)
                           : std::max(alternating_[shear], alternating_[bending]);
}

namespace {

// What the fluid answers to `force` in the first step, as seen by each test force, at all
// frequencies.
std::vector<std::vector<Complex>> impulse(Bath& bath, const VectorXd& force,
                                          const std::vector<VectorXd>& tests, int steps) {
  const double scale = small_force / force.cwiseAbs().maxCoeff();
  std::vector<std::vector<double>> answers(tests.size());
  for (int j = 0; j < steps; ++j) {
    const VectorXd& u = bath.step(j == 0 ? VectorXd(scale * force) : VectorXd::Zero(force.size()));
    // The tail is faded out: cut off, it would look like a resonance.
    const double fade = (0.5 + 0.5 * std::cos(pi * j / steps)) / scale;
    for (std::size_t t = 0; t < tests.size(); ++t) answers[t].push_back(fade * tests[t].dot(u));
  }
  std::vector<std::vector<Complex>> result(tests.size());
  for (std::size_t t = 0; t < tests.size(); ++t) {
    for (int i = 0; i < frequency_count; ++i)
      result[t].push_back(transform(answers[t], std::polar(1.0, frequency(i))));
  }
  return result;
}

}  // namespace

void StabilityModel::measure_breathing(const StabilityProblem& problem, int steps) {
  const surface::Mesh mesh = mesh_of(problem);
  const VectorXd mass = masses(mesh);
  VectorXd field = VectorXd::Zero(mass.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3d& x = mesh.vertices[static_cast<std::size_t>(a)];
    const Vector3d normal = (mesh.vertices[static_cast<std::size_t>(b)] - x)
                                .cross(mesh.vertices[static_cast<std::size_t>(c)] - x);
    for (const int v : {a, b, c}) field.segment<3>(3 * static_cast<Index>(v)) += normal;
  }
  field = field.cwiseQuotient(mass);
  normalise(field, mass);
  Harmonic mode;
  Bath bath(problem, mesh);
  mode.answer[2] = impulse(bath, mass.cwiseProduct(field), {mass.cwiseProduct(field)}, steps)[0];
  for (const std::size_t entry : {0, 1, 3}) mode.answer[entry].resize(frequency_count);
  for (std::size_t part = 0; part < part_count; ++part) {
    const membrane::Moduli k = only(problem.moduli, part);
    if (any(k)) mode.stiffness[part][2] = field.dot(Stiffness(mesh, k) * field);
  }
  harmonics_.push_back(std::move(mode));
}

void StabilityModel::measure_harmonics(const StabilityProblem& problem, int steps) {
  // Also of a biconcave cell, whose area is that of the sphere of radius a. The axis is near one of
  // the lattice's, where sound of short waves is damped least, but on no symmetry of the mesh.
  StabilityProblem sphere = problem;
  sphere.shape = "sphere";
  sphere.rotation.setIdentity();
  const surface::Mesh mesh = mesh_of(sphere);
  const VectorXd mass = masses(mesh);
  const Vector3d axis = Vector3d(2, 1, 8).normalized();
  const Vector3d side = axis.unitOrthogonal();

  const auto last = static_cast<std::size_t>(std::ceil(largest_wave * problem.radius));
  const auto stride = static_cast<std::size_t>(std::max(1L, std::lround(problem.radius / 9)));
  std::vector<std::size_t> degrees;
  for (std::size_t l = 1; l <= last; l += stride) degrees.push_back(l);

  // N about the axis for its coupling to L, and N turned once round it, which other fields do not
  // feel: so that one impulse serves all.
  enum { L, N, T, turned_N, field_count };
  std::vector<std::array<VectorXd, field_count>> fields(degrees.size());
  for (auto& field : fields) field.fill(VectorXd::Zero(mass.size()));
  std::vector<double> p(last + 1);
  std::vector<double> slope(last + 1);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vector3d r = mesh.vertices[i].normalized();
    const double t = std::clamp(r.dot(axis), -1.0, 1.0);
    legendre(t, p, slope);
    for (std::size_t k = 0; k < degrees.size(); ++k) {
      const auto at = static_cast<Index>(3 * i);
      const double d = slope[degrees[k]];
      fields[k][L].segment<3>(at) = d * (axis - t * r);
      fields[k][N].segment<3>(at) = p[degrees[k]] * r;
      fields[k][T].segment<3>(at) = d * r.cross(axis);
      fields[k][turned_N].segment<3>(at) = d * r.dot(side) * r;
    }
  }
  VectorXd force = VectorXd::Zero(mass.size());
  std::vector<VectorXd> tests;
  for (auto& field : fields) {
    for (VectorXd& f : field) {
      normalise(f, mass);
      tests.emplace_back(mass.cwiseProduct(f));
    }
    force += field[L] + field[T] + field[turned_N];
  }
  Bath bath(sphere, mesh);
  auto answers = impulse(bath, mass.cwiseProduct(force), tests, steps);

  std::vector<Stiffness> stiffness;
  for (const Part part : {shear, bending}) stiffness.emplace_back(mesh, only(problem.moduli, part));
  for (std::size_t k = 0; k < degrees.size(); ++k) {
    Harmonic h;
    h.degree = static_cast<int>(degrees[k]);
    h.answer = {std::move(answers[field_count * k + L]), std::move(answers[field_count * k + N]),
                std::move(answers[field_count * k + turned_N]),
                std::move(answers[field_count * k + T])};
    for (const Part part : {shear, bending}) {
      if (!any(only(problem.moduli, part))) continue;
      const VectorXd normal_force = stiffness[part] * fields[k][N];
      h.stiffness[part] = {fields[k][L].dot(stiffness[part] * fields[k][L]),
                           fields[k][L].dot(normal_force), fields[k][N].dot(normal_force),
                           fields[k][T].dot(stiffness[part] * fields[k][T])};
    }
    harmonics_.push_back(std::move(h));
  }
}

// A mode x_n ~ z^n obeys (z - 1) x = -w(z) G(z) K x, w the scheme's weights. It is neutral at |z| =
// 1: moduli are at their limit when divided by a real eigenvalue of w G K/(1 - z), which is the
// load.
StabilityModel::Weakest StabilityModel::swinging(const Shares& shares,
                                                 std::span<const double> weights) const {
  Weakest worst;
  for (const Harmonic& h : harmonics_) {
    std::array<double, 4> k{};
    for (std::size_t part = 0; part < part_count; ++part) {
      for (std::size_t entry = 0; entry < 4; ++entry)
        k[entry] += shares[part] * h.stiffness[part][entry];
    }
    std::array<Complex, 3> before{};
    for (int i = 0; i < frequency_count; ++i) {
      const Complex z = std::polar(1.0, frequency(i));
      const Complex factor = transform(weights, z) / (1.0 - z);
      const auto n = static_cast<std::size_t>(i);
      const Complex ll = h.answer[0][n] + slip_;
      const Complex ln = h.answer[1][n];
      const Complex nn = h.answer[2][n] + slip_;
      const Complex tt = h.answer[3][n] + slip_;
      const Complex half = 0.5 * (ll * k[0] + 2.0 * ln * k[1] + nn * k[2]);
      const Complex root =
          std::sqrt(half * half - (ll * nn - ln * ln) * (k[0] * k[2] - k[1] * k[1]));
      std::array<Complex, 3> e{factor * (half + root), factor * (half - root), factor * tt * k[3]};
      // The two branches of L and N, each by continuity.
      if (std::abs(e[0] - before[0]) + std::abs(e[1] - before[1]) >
          std::abs(e[1] - before[0]) + std::abs(e[0] - before[1]))
        std::swap(e[0], e[1]);
      for (std::size_t b = 0; b < e.size(); ++b) {
        if (i == 0 || (b < 2 && frequency(i - 1) < slowest_of_sound)) continue;
        const bool last = i + 1 == frequency_count;  // z = -1, where all is real
        if (!last && (e[b].imag() > 0) == (before[b].imag() > 0)) continue;
        const double share = before[b].imag() / (before[b].imag() - e[b].imag());
        const double load =
            last ? e[b].real() : before[b].real() + share * (e[b].real() - before[b].real());
        if (load > worst.load) worst = {load, frequency(i), h.degree};
      }
      before = e;
    }
  }
  return worst;
}

StabilityModel::Weakest StabilityModel::weakest(std::span<const double> weights) const {
  if (weights.empty()) {
    throw std::invalid_argument("stability: a scheme without weights has no limit known here");
  }
  const double alternate = transform(weights, -1).real() / 2 * alternating_total_;
  const Weakest swing = swinging({1, 1, 1}, weights);
  return alternate > swing.load ? Weakest{alternate, pi, -1} : swing;
}

const StabilityLoad& StabilityModel::load(std::span<const double> weights) const {
  for (const auto& [known, load] : loads_)
    if (std::ranges::equal(known, weights)) return load;
  loads_.emplace_back(std::vector(weights.begin(), weights.end()), find_load(weights));
  return loads_.back().second;
}

StabilityLoad StabilityModel::find_load(std::span<const double> weights) const {
  StabilityLoad load;
  load.total = weakest(weights).load;
  const double alternate = transform(weights, -1).real() / 2;
  load.shear = std::max(swinging({1, 0, 0}, weights).load, alternate * alternating_[shear]);
  load.bending = std::max(swinging({0, 1, 0}, weights).load, alternate * alternating_[bending]);
  load.volume = swinging({0, 0, 1}, weights).load;
  return load;
}

bool relied_on(const membrane::Scheme& scheme, const StabilityModel& model) {
  const membrane::SchemeTraits& traits = scheme.traits;
  if (!traits.weights.empty()) return model.load(traits.weights).total <= sound_load;
  if (std::isinf(traits.reach)) return true;
  return model.load(membrane::reference_scheme().traits.weights).total <= traits.reach;
}

const membrane::Scheme& advised_scheme(const StabilityModel& model) {
  const membrane::Scheme* cheapest = nullptr;
  const membrane::Scheme* furthest = &membrane::schemes().front();
  for (const membrane::Scheme& scheme : membrane::schemes()) {
    if (scheme.traits.reach > furthest->traits.reach) furthest = &scheme;
    if (cheapest != nullptr && scheme.traits.cost >= cheapest->traits.cost) continue;
    if (relied_on(scheme, model)) cheapest = &scheme;
  }
  return cheapest != nullptr ? *cheapest : *furthest;
}

double seconds_to_measure(const StabilityProblem& given) {
  const StabilityProblem problem = of_bearable_size(given);
  const double nodes =
      std::pow(box_nodes(surface::make_shape(problem.shape, problem.radius)->reach()), 3);
  const auto vertices = static_cast<double>(surface::vertex_count(problem.frequency));
  // Breathing, harmonics, and the alternation of shear, bending and both, each in a bath of its
  // own. Measured on a core of an AMD EPYC.
  constexpr double baths = 5;
  constexpr double node_step = 12e-9;
  constexpr double vertex_step = 200e-9;  // spreading, interpolation, stiffness
  constexpr double vertex_once = 40e-6;   // the stiffness assembled eight times
  return baths * steps_of_memory(problem.tau) * (node_step * nodes + vertex_step * vertices) +
         vertex_once * vertices;
}

const StabilityModel* StabilityModels::operator[](std::size_t body) {
  const StabilityProblem problem = stability_problem(plan_, body);
  for (const auto& [known, model] : models_)
    if (known == problem) return model.get();
  const double seconds = seconds_to_measure(problem);
  if (seconds > left_) return nullptr;
  left_ -= seconds;
  models_.emplace_back(problem, std::make_unique<StabilityModel>(problem));
  return models_.back().second.get();
}

}  // namespace ductile::drivers
