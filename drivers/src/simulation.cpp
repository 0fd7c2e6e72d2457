#include "simulation.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>

#include "assembly.hpp"
#include "bodies.hpp"
#include "ductile/coupling/coupler.hpp"
#include "ductile/membrane/petsc.hpp"
#include "errors.hpp"
#include "progress.hpp"
#include "run_directory.hpp"
#include "summary.hpp"
#include "surfaces.hpp"
#include "trajectory.hpp"
#include "verdict.hpp"
#include "version.hpp"

namespace ductile::drivers {
namespace {

volatile std::sig_atomic_t stop_requested = 0;
// Once: a second signal ends the program at once.
extern "C" void request_stop(int signal) {
  stop_requested = 1;
  std::signal(signal, SIG_DFL);
}

void check(int code, const char* call) {
  if (code != MPI_SUCCESS) throw std::runtime_error(std::string("MPI: ") + call + " failed");
}

constexpr std::int64_t finite_interval = 256;  // steps between two looks at the whole fluid

// Why the loop goes on or ends; the largest of all ranks' counts.
enum Signal : int {
  go_on,
  interrupted,
  decided,
  too_far,
  failed_output,
};

// The files and judgements of a run, on rank 0.
class Recorder {
 public:
  Recorder(const Scenario& scenario, const LatticeSetup& setup, const RunOptions& options)
      : scenario_(scenario),
        setup_(setup),
        directory_(options.directory, options.force),
        trajectory_(directory_.trajectory(), names(scenario)),
        judge_(scenario.run.stop_distance),
        volume_error_(scenario.bodies.size(), 0.0) {
    directory_.write_scenario(options.scenario_text);
    for (std::size_t b = 0; b < scenario.bodies.size(); ++b) {
      lateral_.emplace_back(rules::lateral);
      strain_.emplace_back(rules::strain);
    }
    const OutputOptions& output = scenario.output;
    if (output.surfaces_every == 0 && output.field_every == 0) return;
    std::vector<SurfaceMesh> meshes;
    for (std::size_t b = 0; b < scenario.bodies.size(); ++b) {
      SurfaceMesh mesh{scenario.bodies[b].name, 0, surface_triangles(scenario, setup, b)};
      mesh.vertices = mesh.triangles.size() / 2 + 2;  // Euler: a closed surface
      meshes.push_back(std::move(mesh));
    }
    std::optional<FluidLattice> lattice;
    if (output.field_every > 0) {
      lattice.emplace();
      for (std::size_t a = 0; a < 3; ++a) {
        lattice->nodes[a] = static_cast<std::size_t>(setup.nodes[a]);
      }
      lattice->origin = setup.position(Eigen::Vector3d::Zero());
      lattice->spacing = 1 / setup.half_width;
    }
    surfaces_.emplace(directory_.path(), std::move(meshes), setup.length / setup.half_width,
                      lattice);
  }

  [[nodiscard]] bool pair() const { return scenario_.bodies.size() == 2; }
  [[nodiscard]] std::vector<Sample>& samples() { return samples_; }
  [[nodiscard]] Surfaces& surfaces() { return *surfaces_; }

  // Takes a sample; says whether the run may end.
  Signal take(const Sample& sample) {
    trajectory_.write(sample);
    samples_.push_back(sample);
    for (std::size_t b = 0; b < sample.bodies.size(); ++b) {
      const BodySample& body = sample.bodies[b];
      lateral_[b].update(sample.time, body.position.x());
      if (!body.capsule) continue;
      strain_[b].update(sample.time, body.strain_energy);
      volume_error_[b] = std::max(volume_error_[b], std::abs(body.volume_error));
    }
    if (!pair()) return go_on;
    judge_.update(sample);
    if (std::abs(axial_distance(sample)) >= scenario_.run.stop_distance) return too_far;
    return judge_.verdict().decided() && scenario_.run.until_decided ? decided : go_on;
  }

  // Something to tell at once, and again in the end.
  void warn(const std::string& warning) {
    std::fprintf(stderr, "warning: %s\n", warning.c_str());
    warnings_.push_back(warning);
  }

  Summary summarise(RunStatus status, const std::vector<membrane::SolveStatistics>& solvers) const {
    const Sample& last = samples_.back();
    Summary summary;
    summary.warnings = warnings_;
    summary.scenario = scenario_.name;
    summary.status = status;
    if (pair()) {
      summary.verdict = judge_.verdict();
      summary.dz = axial_distance(last);
      const PairClass pair_class = judge_.verdict().pair_class;
      if (judge_.verdict().decided() && pair_class != PairClass::unstable &&
          std::abs(*summary.dz) > 0.5 * setup_.length / setup_.half_width) {
        summary.warnings.emplace_back(
            "dz is beyond half of the channel's length, where the nearest neighbour is a periodic "
            "image; use a longer channel");
      }
    }
    for (std::size_t b = 0; b < last.bodies.size(); ++b) {
      const BodySample& sample = last.bodies[b];
      const BodyOptions& options = scenario_.bodies[b];
      BodySummary body;
      body.name = options.name;
      body.position = sample.position;
      body.velocity = sample.velocity;
      body.lateral = lateral_[b].outlook();
      if (sample.capsule) {
        CapsuleSummary capsule;
        capsule.k_v = options.membrane.volume_modulus;
        capsule.volume_error_max = volume_error_[b];
        capsule.deformation = sample.deformation;
        capsule.strain_energy = sample.strain_energy;
        capsule.strain = strain_[b].outlook();
        capsule.solver = solvers[b];
        if (capsule.volume_error_max > 0.01) {
          summary.warnings.push_back("the volume of " + options.name +
                                     " changed by more than 1%; raise volume_modulus");
        }
        // An oscillating pair's strain swings along.
        const bool swings = pair() && (judge_.verdict().pair_class == PairClass::damped ||
                                       judge_.verdict().pair_class == PairClass::bounded);
        if (capsule.strain && !capsule.strain->settled && !swings) {
          summary.warnings.push_back("the strain energy of " + options.name +
                                     (capsule.strain->rate > 0 ? " still grows" : " still falls") +
                                     "; see doc/equations.md on the mobility");
        }
        body.capsule = capsule;
      }
      summary.bodies.push_back(std::move(body));
    }
    return summary;
  }
  void write(const Summary& summary) const { write_summary(directory_.summary(), summary); }

 private:
  static std::vector<std::string> names(const Scenario& scenario) {
    std::vector<std::string> list;
    for (const BodyOptions& body : scenario.bodies) list.push_back(body.name);
    return list;
  }

  const Scenario& scenario_;
  const LatticeSetup& setup_;
  RunDirectory directory_;
  Trajectory trajectory_;
  PairJudge judge_;
  std::vector<SettlingWatch> lateral_;
  std::vector<SettlingWatch> strain_;
  std::vector<double> volume_error_;
  std::optional<Surfaces> surfaces_;
  std::vector<std::string> warnings_;
  std::vector<Sample> samples_;
};

// All of a run on one rank; rank 0 has the recorder too.
class Simulation {
 public:
  Simulation(const Scenario& scenario, const LatticeSetup& setup, MPI_Comm comm)
      : scenario_(scenario),
        setup_(setup),
        comm_(comm),
        rank_(rank_of(comm)),
        ranks_(size_of(comm)),
        assembly_(scenario, setup, comm),
        fluid_(assembly_.fluid()),
        coupler_(assembly_.coupler()) {}

  RunResult run(const RunOptions& options);

 private:
  static int rank_of(MPI_Comm comm) {
    int rank = 0;
    MPI_Comm_rank(comm, &rank);
    return rank;
  }
  static int size_of(MPI_Comm comm) {
    int size = 1;
    MPI_Comm_size(comm, &size);
    return size;
  }
  [[nodiscard]] double time() const { return setup_.time(fluid_.time()); }

  // Rank 0 does the work, which may fail; every rank learns the outcome.
  Signal on_root(const std::function<Signal()>& work);
  std::vector<double> fetch(std::size_t body, std::span<const double> values);
  Sample sample();
  std::vector<membrane::SolveStatistics> solvers();
  void write_frame(bool with_fluid);
  Signal record(std::int64_t step);
  void check_fluid();
  void report_unread_options();
  RunResult finish(RunStatus status, std::optional<BlowUp> blow_up);

  const Scenario& scenario_;
  const LatticeSetup& setup_;
  MPI_Comm comm_;
  int rank_;
  int ranks_;
  Assembly assembly_;
  fluid::Fluid& fluid_;
  coupling::Coupler& coupler_;
  std::optional<Recorder> recorder_;
  std::optional<Progress> progress_;
  bool profiled_ = false;
  double start_ = 0;  // of the loop, by Progress::steady_seconds
};

Signal Simulation::on_root(const std::function<Signal()>& work) {
  int signal = go_on;
  if (rank_ == 0) {
    try {
      signal = work();
    } catch (const std::exception& error) {
      if (progress_) progress_->finish();
      std::fprintf(stderr, "ductile: %s\n", error.what());
      signal = failed_output;
    }
  }
  check(MPI_Bcast(&signal, 1, MPI_INT, 0, comm_), "MPI_Bcast");
  return static_cast<Signal>(signal);
}

// `values` of the body's owner, on rank 0.
std::vector<double> Simulation::fetch(std::size_t body, std::span<const double> values) {
  std::vector<double> result(values.begin(), values.end());
  const int from = assembly_.owner(body);
  if (from == 0) return result;
  const int tag = static_cast<int>(body);
  if (rank_ == from) {
    check(MPI_Send(result.data(), static_cast<int>(result.size()), MPI_DOUBLE, 0, tag, comm_),
          "MPI_Send");
  } else if (rank_ == 0) {
    MPI_Status status;
    int count = 0;
    check(MPI_Probe(from, tag, comm_, &status), "MPI_Probe");
    check(MPI_Get_count(&status, MPI_DOUBLE, &count), "MPI_Get_count");
    result.resize(static_cast<std::size_t>(count));
    check(MPI_Recv(result.data(), count, MPI_DOUBLE, from, tag, comm_, MPI_STATUS_IGNORE),
          "MPI_Recv");
  }
  return result;
}

// All bodies, on rank 0.
Sample Simulation::sample() {
  Sample sample;
  sample.time = time();
  for (std::size_t b = 0; b < scenario_.bodies.size(); ++b) {
    std::vector<double> values;
    if (const ImmersedBody* body = assembly_.own(b)) {
      const BodySample s = body->sample();
      values = {s.position.x(),  s.position.y(), s.position.z(),       s.velocity.x(),
                s.velocity.y(),  s.velocity.z(), s.deformation,        s.volume_error,
                s.strain_energy, s.slip,         s.capsule ? 1.0 : 0.0};
    }
    values = fetch(b, values);
    if (rank_ != 0) continue;
    BodySample s;
    s.position = {values[0], values[1], values[2]};
    s.velocity = {values[3], values[4], values[5]};
    s.deformation = values[6];
    s.volume_error = values[7];
    s.strain_energy = values[8];
    s.slip = values[9];
    s.capsule = values[10] != 0;
    sample.bodies.push_back(s);
  }
  return sample;
}

// What the bodies' integrators have spent, on rank 0; zeros elsewhere.
std::vector<membrane::SolveStatistics> Simulation::solvers() {
  std::vector<membrane::SolveStatistics> list(scenario_.bodies.size());
  for (std::size_t b = 0; b < list.size(); ++b) {
    std::vector<double> values;
    if (const ImmersedBody* body = assembly_.own(b)) {
      const membrane::SolveStatistics s = body->solver();
      for (const std::int64_t count :
           {s.solves, s.newton_iterations, s.krylov_iterations, s.tangents, s.step_cuts}) {
        values.push_back(static_cast<double>(count));
      }
    }
    values = fetch(b, values);
    if (rank_ != 0) continue;
    const auto count = [&values](std::size_t n) { return static_cast<std::int64_t>(values[n]); };
    list[b] = {count(0), count(1), count(2), count(3), count(4)};
  }
  return list;
}

void Simulation::write_frame(bool with_fluid) {
  std::vector<std::array<std::vector<double>, 3>> arrays;
  const double velocity_unit = setup_.velocity(Eigen::Vector3d::UnitX()).x();
  const double force_unit = 1 / (setup_.nu * setup_.nu);
  for (std::size_t b = 0; b < scenario_.bodies.size(); ++b) {
    const ImmersedBody* body = assembly_.own(b);
    const auto get = [&](auto member) {
      return fetch(b, body != nullptr ? (body->*member)() : std::span<const double>());
    };
    arrays.push_back({get(&ImmersedBody::positions), get(&ImmersedBody::velocities),
                      get(&ImmersedBody::forces)});
    auto& [x, u, f] = arrays.back();
    for (std::size_t n = 0; n + 2 < x.size(); n += 3) {
      const Eigen::Vector3d p = setup_.position({x[n], x[n + 1], x[n + 2]});
      std::copy(p.data(), p.data() + 3, &x[n]);
    }
    for (double& value : u) value *= velocity_unit;
    for (double& value : f) value *= force_unit;
  }
  std::vector<double> density;
  std::vector<double> velocity;
  if (with_fluid) {
    // Slabs are put side by side along z, one after the other.
    const auto columns =
        static_cast<std::size_t>(setup_.nodes[0]) * static_cast<std::size_t>(setup_.nodes[1]);
    const auto planes = static_cast<std::size_t>(setup_.nodes[2]);
    const auto own_planes = static_cast<std::size_t>(fluid_.slab().size());
    std::vector<double> rho(columns * own_planes);
    std::vector<double> u(3 * columns * own_planes);
    fluid_.fields(rho, u);
    if (rank_ != 0) {
      check(MPI_Send(rho.data(), static_cast<int>(rho.size()), MPI_DOUBLE, 0, 0, comm_),
            "MPI_Send");
      check(MPI_Send(u.data(), static_cast<int>(u.size()), MPI_DOUBLE, 0, 1, comm_), "MPI_Send");
    } else {
      density.resize(columns * planes);
      velocity.resize(3 * columns * planes);
      for (int r = 0; r < ranks_; ++r) {
        const fluid::Range slab = fluid_.slab(r);
        const auto count = static_cast<std::size_t>(slab.size());
        if (r > 0) {
          rho.resize(columns * count);
          u.resize(3 * columns * count);
          check(MPI_Recv(rho.data(), static_cast<int>(rho.size()), MPI_DOUBLE, r, 0, comm_,
                         MPI_STATUS_IGNORE),
                "MPI_Recv");
          check(MPI_Recv(u.data(), static_cast<int>(u.size()), MPI_DOUBLE, r, 1, comm_,
                         MPI_STATUS_IGNORE),
                "MPI_Recv");
        }
        for (std::size_t column = 0; column < columns; ++column) {
          for (std::size_t k = 0; k < count; ++k) {
            const std::size_t to = column * planes + static_cast<std::size_t>(slab.begin) + k;
            density[to] = rho[column * count + k];
            for (std::size_t a = 0; a < 3; ++a) {
              velocity[a * density.size() + to] =
                  velocity_unit * u[a * rho.size() + column * count + k];
            }
          }
        }
      }
    }
  }
  if (rank_ != 0) return;
  std::vector<SurfaceState> states;
  states.reserve(arrays.size());
  for (const auto& [x, u, f] : arrays) states.push_back({x, u, f});
  FluidState fluid;
  fluid.density = density;
  for (std::size_t a = 0; a < 3; ++a) {
    fluid.velocity[a] = std::span(velocity).subspan(a * density.size(), density.size());
  }
  recorder_->surfaces().write(time(), states, with_fluid ? &fluid : nullptr);
}

// Whatever is due after `step` steps. Collective.
Signal Simulation::record(std::int64_t step) {
  const auto due = [&](double interval) {
    const std::int64_t steps = setup_.steps(interval);
    return steps > 0 && (step % steps == 0 || step == setup_.total_steps);
  };
  const OutputOptions& output = scenario_.output;
  if (due(output.surfaces_every) || due(output.field_every)) {
    // Every rank sends before rank 0 writes, so a full disk holds up nobody.
    std::exception_ptr failure;
    try {
      write_frame(due(output.field_every));
    } catch (const OutputError&) {  // rank 0's alone
      failure = std::current_exception();
    }
    const Signal signal = on_root([&]() -> Signal {
      if (failure) std::rethrow_exception(failure);
      return go_on;
    });
    if (signal != go_on) return signal;
  }
  if (!due(output.every)) return go_on;
  const Sample now = sample();
  const Signal signal = on_root([&] {
    const Signal verdict = recorder_->take(now);
    if (recorder_->pair()) {
      char text[32];
      std::snprintf(text, sizeof text, "dz = %.3f", axial_distance(now));
      progress_->note(text);
    }
    return verdict;
  });
  int stop = signal == go_on && stop_requested != 0 ? interrupted : signal;
  check(MPI_Allreduce(MPI_IN_PLACE, &stop, 1, MPI_INT, MPI_MAX, comm_), "MPI_Allreduce");
  return static_cast<Signal>(stop);
}

// Throws FluidBlowUp on every rank.
struct FluidBlowUp : std::runtime_error {
  using std::runtime_error::runtime_error;
};
void Simulation::check_fluid() {
  if (!fluid_.totals().finite()) {
    throw FluidBlowUp(
        "its density or velocity is no longer finite: too high a velocity, or a body too stiff");
  }
}

// By the end of the first step every solver has read its options. Collective.
void Simulation::report_unread_options() {
  std::vector<int> used;
  for (const PetscOption& option : scenario_.petsc) {
    PetscBool read = PETSC_FALSE;
    membrane::petsc_check(PetscOptionsUsed(nullptr, option.name.c_str(), &read));
    used.push_back(read == PETSC_TRUE ? 1 : 0);
  }
  check(MPI_Allreduce(MPI_IN_PLACE, used.data(), static_cast<int>(used.size()), MPI_INT, MPI_MAX,
                      comm_),
        "MPI_Allreduce");
  if (rank_ != 0) return;
  for (std::size_t n = 0; n < used.size(); ++n) {
    if (used[n] != 0) continue;
    recorder_->warn("[petsc] " + scenario_.petsc[n].name +
                    ": nothing in this run reads this option of PETSc");
  }
}

RunResult not_done(int exit_code) {
  RunResult result;
  result.exit_code = static_cast<ExitCode>(exit_code);
  return result;
}

RunResult Simulation::run(const RunOptions& options) {
  profiled_ = options.profile;
  // A refusal to overwrite is the user's to mend; anything else here is the system's.
  int exit_code = exit_success;
  if (rank_ == 0) {
    try {
      recorder_.emplace(scenario_, setup_, options);
      const auto nodes = setup_.node_count();
      // Under mpirun no rank sees the terminal; who starts it there says so.
      const bool terminal = isatty(STDERR_FILENO) != 0 || std::getenv("DUCTILE_LIVE") != nullptr;
      progress_.emplace(setup_.time(setup_.total_steps), nodes, stderr, terminal,
                        Progress::steady_seconds);
    } catch (const InputError& error) {
      std::fprintf(stderr, "%s\n", error.what());
      exit_code = exit_bad_input;
    } catch (const std::exception& error) {
      std::fprintf(stderr, "ductile: %s\n", error.what());
      exit_code = exit_failure;
    }
  }
  check(MPI_Bcast(&exit_code, 1, MPI_INT, 0, comm_), "MPI_Bcast");
  if (exit_code != exit_success) return not_done(exit_code);

  for (const int signal : {SIGTERM, SIGINT, SIGUSR1}) std::signal(signal, request_stop);
  start_ = Progress::steady_seconds();
  const auto blew_up = [&](BlowUp blow_up) {
    blow_up.reason += "; `ductile check` tells the margins of stability";
    return finish(RunStatus::blew_up, std::move(blow_up));
  };
  try {
    Signal signal = record(0);
    while (signal == go_on && fluid_.time() < setup_.total_steps) {
      coupler_.step();
      if (fluid_.time() == 1) report_unread_options();
      if (fluid_.time() % finite_interval == 0) check_fluid();
      signal = record(fluid_.time());
      if (progress_) progress_->update(time(), fluid_.time());
    }
    if (signal == failed_output) return not_done(exit_failure);
    const RunStatus status = signal == decided       ? RunStatus::decided
                             : signal == too_far     ? RunStatus::stop_distance
                             : signal == interrupted ? RunStatus::interrupted
                                                     : RunStatus::finished;
    return finish(status, std::nullopt);
  } catch (const coupling::BodyFailure& failure) {
    if (failure.step() == 0) report_unread_options();
    return blew_up({failure.step(), scenario_.bodies[static_cast<std::size_t>(failure.body())].name,
                    failure.marker(), failure.reason()});
  } catch (const FluidBlowUp& failure) {
    return blew_up({fluid_.time(), "", std::nullopt, failure.what()});
  }
}

RunResult Simulation::finish(RunStatus status, std::optional<BlowUp> blow_up) {
  const double wall_time = Progress::steady_seconds() - start_;
  const std::int64_t steps = blow_up ? blow_up->step : fluid_.time();  // completed
  std::optional<RunProfile> times;
  if (profiled_) times = gathered(coupler_.profile(), wall_time, comm_);
  const std::vector<membrane::SolveStatistics> spent = solvers();
  RunResult result;
  result.exit_code = status == RunStatus::blew_up ? exit_blow_up : exit_success;
  result.interrupted = status == RunStatus::interrupted;
  const Signal signal = on_root([&] {
    progress_->finish();
    Summary summary = recorder_->summarise(status, spent);
    if (status == RunStatus::finished && summary.verdict && !summary.verdict->decided()) {
      summary.status = RunStatus::time_limit;
    }
    summary.blow_up = std::move(blow_up);
    summary.time = setup_.time(steps);
    summary.steps = steps;
    summary.wall_time = wall_time;
    summary.updates_per_second =
        static_cast<double>(setup_.node_count()) * static_cast<double>(steps) / wall_time;
    summary.ranks = ranks_;
    summary.profile = std::move(times);
    summary.versions = versions();
    recorder_->write(summary);
    result.summary = std::move(summary);
    result.samples = std::move(recorder_->samples());
    return go_on;
  });
  if (signal == failed_output) return not_done(exit_failure);
  return result;
}

}  // namespace

RunResult run_simulation(const Scenario& scenario, const LatticeSetup& setup,
                         const RunOptions& options, MPI_Comm comm) {
  return Simulation(scenario, setup, comm).run(options);
}

}  // namespace ductile::drivers
