#include "ductile/suspension/suspension.hpp"

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <exception>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "films.hpp"
#include "gap_finder.hpp"
#include "gather.hpp"
#include "planes.hpp"

namespace ductile::suspension {
namespace {

using fluid::mpi_check;

// A lattice that follows the bodies: how often its acceleration is chosen, and the time in which it
// would catch up. Bodies change their velocity over thousands of steps, that of their markers
// trembles from node to node.
constexpr std::int64_t steering_steps = 8;
constexpr double relaxation_steps = 64;

Plan checked(Plan plan) {
  plan.check();
  return plan;
}

}  // namespace

Suspension::Suspension(Plan plan, MPI_Comm comm)
    : plan_(checked(std::move(plan))),
      comm_(comm),
      owners_(suspension::owners(plan_, comm_.size())),
      fluid_(make_fluid(plan_, comm_.get())) {
  make_bodies();
  films_ = Films::make(plan_);
  std::vector<coupling::Member> members;
  for (const Owned& owned : bodies_) {
    members.push_back({static_cast<int>(owned.index), &owned.body->markers()});
  }
  coupler_.emplace(fluid_, std::move(members), static_cast<int>(plan_.bodies.size()));
}

Suspension::~Suspension() = default;

// A body that cannot be made is its owner's to notice, and every rank's to hear of.
void Suspension::make_bodies() {
  int refused = INT_MAX;
  std::string reason;
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    if (owner(b) != rank()) continue;
    try {
      bodies_.push_back({b, make_body(plan_, b)});
    } catch (const std::exception& error) {
      refused = static_cast<int>(b);
      reason = error.what();
      break;
    }
  }
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, &refused, 1, MPI_INT, MPI_MIN, comm()), "MPI_Allreduce");
  if (refused == INT_MAX) return;
  const auto body = static_cast<std::size_t>(refused);
  int length = static_cast<int>(reason.size());
  mpi_check(MPI_Bcast(&length, 1, MPI_INT, owner(body), comm()), "MPI_Bcast");
  reason.resize(static_cast<std::size_t>(length));
  mpi_check(MPI_Bcast(reason.data(), length, MPI_CHAR, owner(body), comm()), "MPI_Bcast");
  throw std::invalid_argument("body " + plan_.bodies[body].name + ": " + reason);
}

void Suspension::step() {
  if (films_) lubricate();
  coupler_->step();
  if (films_) films_->lubrication().accept();
  if (plan_.follow && !plan_.bodies.empty() && steps() % steering_steps == 0) steer();
}

// Every rank finds all forces, from the motions of all spheres; each number of these is one rank's,
// and zero elsewhere.
void Suspension::lubricate() {
  const std::vector<std::size_t>& spheres = films_->bodies();
  std::vector<double> numbers(9 * spheres.size(), 0.0);
  const auto for_own = [&](const auto& f) {
    for (const Owned& owned : bodies_) {
      const auto found = std::ranges::lower_bound(spheres, owned.index);
      if (found == spheres.end() || *found != owned.index) continue;
      f(static_cast<std::size_t>(found - spheres.begin()), *owned.body->rigid());
    }
  };
  for_own([&](std::size_t n, const rigid::Body& body) {
    const auto put = [&](std::size_t k, const Eigen::Vector3d& vector) {
      Eigen::Vector3d::Map(&numbers[9 * n + 3 * k]) = vector;
    };
    put(0, body.state().position);
    put(1, body.state().velocity);
    put(2, body.state().angular_velocity);
  });
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, numbers.data(), static_cast<int>(numbers.size()),
                          MPI_DOUBLE, MPI_SUM, comm()),
            "MPI_Allreduce");
  std::vector<rigid::SphereMotion> motions;
  for (std::size_t n = 0; n < numbers.size(); n += 9) {
    const auto get = [&](std::size_t k) { return Eigen::Vector3d::Map(&numbers[n + 3 * k]); };
    motions.push_back({get(0), get(1), get(2)});
  }
  const std::span<const rigid::FilmForce> films = films_->lubrication().forces(motions);
  for_own([&](std::size_t n, rigid::Body& body) {
    body.set_film_force(films[n].force, films[n].torque);
  });
}

// The lattice's velocity relaxes to the mean of the bodies', a body's being that of its markers.
void Suspension::steer() {
  std::vector<double> velocity(plan_.bodies.size(), 0.0);
  for (const Owned& owned : bodies_) {
    const std::vector<double> u = owned.body->velocities();
    double sum = 0;
    for (std::size_t n = 2; n < u.size(); n += 3) sum += u[n];
    velocity[owned.index] = 3 * sum / static_cast<double>(u.size());
  }
  // Every number is one rank's, and zero elsewhere.
  mpi_check(MPI_Allreduce(MPI_IN_PLACE, velocity.data(), static_cast<int>(velocity.size()),
                          MPI_DOUBLE, MPI_SUM, comm()),
            "MPI_Allreduce");
  const double mean =
      std::accumulate(velocity.begin(), velocity.end(), 0.0) / static_cast<double>(velocity.size());
  fluid_.accelerate((mean - fluid_.motion().velocity) / relaxation_steps);
}

const Body* Suspension::own(std::size_t body) const {
  for (const Owned& owned : bodies_) {
    if (owned.index == body) return owned.body.get();
  }
  return nullptr;
}

Sample Suspension::sample() {
  const Gather gather(comm());
  const double flow = fluid_.flow() / plan_.length();
  Sample all;
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    BodySample body;
    if (const Body* mine = own(b)) body = suspension::sample(mine->observe());
    body.values = gather.from(owner(b), body.values);
    body.capsule = plan_.bodies[b].capsule() != nullptr;
    if (rank() == 0) all.bodies.push_back(std::move(body));
  }
  if (rank() != 0) return all;
  all.time = time();
  const double halves = plan_.fluid.mirror == fluid::Mirror::none ? 1 : 2;
  const double cross_section = 4 * plan_.units.half_width() * plan_.half_width_y();
  const double lattice_velocity = fluid_.motion().velocity;
  all.flow_rate = plan_.units.flow_rate(halves * flow + lattice_velocity * cross_section);
  all.mach = plan_.mach(lattice_velocity);
  for (const BodySample& body : all.bodies) {
    const Eigen::Vector3d u = plan_.units.lattice_velocity(1) * body.velocity() -
                              lattice_velocity * Eigen::Vector3d::UnitZ();
    all.mach = std::max(all.mach, std::sqrt(3.0) * u.norm());
  }
  if (all.bodies.size() > 2) {
    std::vector<double> z;
    for (const BodySample& body : all.bodies) z.push_back(body.position().z());
    all.ahead = distances_ahead(z, plan_.units.length(plan_.length()));
  }
  return all;
}

std::vector<membrane::SolveStatistics> Suspension::solvers() const {
  const Gather gather(comm());
  std::vector<membrane::SolveStatistics> all;
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    std::array<double, 5> counts{};
    if (const Body* mine = own(b)) {
      const membrane::SolveStatistics s = mine->solver();
      std::ranges::transform(
          std::array{s.solves, s.newton_iterations, s.krylov_iterations, s.tangents, s.step_cuts},
          counts.begin(), [](std::int64_t count) { return static_cast<double>(count); });
    }
    const std::vector<double> values = gather.from(owner(b), counts);
    if (rank() != 0) continue;
    const auto count = [&values](std::size_t n) { return static_cast<std::int64_t>(values[n]); };
    all.push_back({count(0), count(1), count(2), count(3), count(4)});
  }
  return all;
}

std::vector<SurfaceState> Suspension::surfaces() const {
  const Gather gather(comm());
  const Units& units = plan_.units;
  std::vector<SurfaceState> all;
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    const Body* mine = own(b);
    const auto get = [&](auto member) {
      using Values = decltype((mine->*member)());
      return gather.from(owner(b), mine != nullptr ? (mine->*member)() : Values());
    };
    SurfaceState surface{get(&Body::positions), get(&Body::velocities), get(&Body::forces)};
    if (rank() != 0) continue;
    for (std::size_t n = 0; n + 2 < surface.position.size(); n += 3) {
      auto x = Eigen::Vector3d::Map(&surface.position[n]);
      x = units.position(x);
    }
    for (double& u : surface.velocity) u = units.velocity(u);
    for (double& f : surface.force) f = units.force(f);
    all.push_back(std::move(surface));
  }
  return all;
}

FluidState Suspension::fields() {
  const Planes planes(fluid_, comm());
  const std::size_t n = planes.own_size();
  std::vector<double> density(n);
  std::vector<double> velocity(3 * n);
  fluid_.fields(density, velocity);
  FluidState all;
  all.way = plan_.units.length(fluid_.motion().position);
  all.density = planes.gathered(density);
  const double lattice_velocity = fluid_.motion().velocity;
  for (std::size_t a = 0; a < 3; ++a) {
    for (const double u : planes.gathered(std::span(velocity).subspan(a * n, n)))
      all.velocity.push_back(plan_.units.velocity(a == 2 ? u + lattice_velocity : u));
  }
  return all;
}

std::vector<Gap> Suspension::gaps(double reach) {
  const Gather gather(comm());
  std::vector<std::vector<double>> positions;
  for (std::size_t b = 0; b < plan_.bodies.size(); ++b) {
    const Body* mine = own(b);
    std::vector<double> of_body = gather.from(
        owner(b), mine != nullptr ? mine->inner_positions() : std::span<const double>());
    if (rank() == 0) positions.push_back(std::move(of_body));
  }
  if (rank() != 0) return {};
  if (!gap_finder_) gap_finder_ = std::make_unique<GapFinder>(plan_);
  return gap_finder_->below(reach, positions);
}

}  // namespace ductile::suspension
