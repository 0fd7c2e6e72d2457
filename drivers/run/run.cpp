#include "run/run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <stdexcept>
#include <utility>

#include "ductile/coupling/coupler.hpp"
#include "ductile/suspension/suspension.hpp"
#include "output/version.hpp"
#include "run/petsc_options.hpp"
#include "run/progress.hpp"
#include "run/recorder.hpp"
#include "run/root.hpp"
#include "run/signals.hpp"
#include "scenario/errors.hpp"

namespace ductile::drivers {
namespace {

constexpr std::int64_t finite_interval = 256;  // steps between two looks at the whole fluid
// Steps between two looks at the gaps: surfaces that approach each other at a Mach number of 0.05
// come nearer by a lattice spacing. A look costs about what a step does at worst.
constexpr std::int64_t gap_interval = 32;

// Why the loop goes on or ends; the largest of all ranks' counts.
enum Signal : int {
  go_on,
  interrupted,
  decided,
  too_far,
  contact,
  failed_output,
};

Signal signal_of(Recorder::Finding finding) {
  if (finding == Recorder::Finding::too_far) return too_far;
  return finding == Recorder::Finding::decided ? decided : go_on;
}

// The fluid has no finite state any more. Thrown on every rank.
struct FluidFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

ExitCode exit_code_of(RunStatus status) {
  if (status == RunStatus::contact) return exit_contact;
  return status == RunStatus::blew_up ? exit_blow_up : exit_success;
}

RunResult not_done(int exit_code) {
  RunResult result;
  result.exit_code = static_cast<ExitCode>(exit_code);
  return result;
}

// All of a run on one rank; rank 0 has the recorder too.
class Run {
 public:
  Run(const Case& given, const RunOptions& options, MPI_Comm comm)
      : given_(given),
        options_(options),
        petsc_(given.scenario.petsc),
        suspension_(given.plan, comm) {}

  RunResult run();
  void view_petsc_log() const { petsc_.view_log(); }

 private:
  int open();
  std::optional<RunStatus> loop();
  Signal on_root(const std::function<Signal()>& work);
  [[nodiscard]] bool due(double interval) const {
    const std::int64_t step = suspension_.steps();
    return Schedule::due(step, interval) ||
           (interval > 0 && (step == given_.schedule.end || contact_));
  }
  Signal write_frame(bool with_fluid);
  Signal record();
  Signal watch_gaps();
  Signal look();
  void check_fluid();
  void report_unread_options();
  RunResult end_at_wall(const coupling::BodyFailure& failure);
  RunResult finish(RunStatus status, std::optional<BlowUp> blow_up);

  const Case& given_;
  const RunOptions& options_;
  PetscOptions petsc_;  // before the solvers
  suspension::Suspension suspension_;
  std::optional<Recorder> recorder_;
  std::optional<Progress> progress_;
  std::optional<StopSignals> signals_;
  std::int64_t last_row_ = -1, last_frame_ = -1;  // the steps of both
  bool contact_ = false;                          // the run ends by one, with a last row and frame
  std::string contact_reason_;
  double start_ = 0;  // of the loop, by Progress::steady_seconds
};

// Rank 0 does the work, which may fail; every rank learns the outcome.
Signal Run::on_root(const std::function<Signal()>& work) {
  return static_cast<Signal>(drivers::on_root(suspension_.comm(), failed_output, [&]() -> int {
    try {
      return work();
    } catch (...) {
      if (progress_) progress_->finish();
      throw;
    }
  }));
}

// A refusal to overwrite is the user's to mend; anything else here is the system's.
int Run::open() {
  return drivers::on_root(suspension_.comm(), exit_failure, [&]() -> int {
    try {
      recorder_.emplace(given_, options_.directory, options_.force, options_.scenario_text,
                        options_.warnings);
    } catch (const InputError& error) {
      fmt::print(stderr, "{}\n", error.what());
      return exit_bad_input;
    }
    // Under mpirun no rank sees the terminal; who starts it there says so.
    const bool terminal = isatty(STDERR_FILENO) != 0 || std::getenv("DUCTILE_LIVE") != nullptr;
    progress_.emplace(given_.plan.units.time(given_.schedule.end), given_.plan.node_count(), stderr,
                      terminal, Progress::steady_seconds);
    return exit_success;
  });
}

// Every rank sends before rank 0 writes, so a full disk holds up nobody.
Signal Run::write_frame(bool with_fluid) {
  const std::vector<suspension::SurfaceState> surfaces = suspension_.surfaces();
  const suspension::FluidState fluid = with_fluid ? suspension_.fields() : suspension::FluidState{};
  return on_root([&] {
    recorder_->write_frame(suspension_.time(), surfaces, with_fluid ? &fluid : nullptr);
    return go_on;
  });
}

// Whatever is due after the step. Collective.
Signal Run::record() {
  const Schedule& schedule = given_.schedule;
  const std::int64_t step = suspension_.steps();
  if ((due(schedule.surfaces) || due(schedule.fields)) && last_frame_ != step) {
    last_frame_ = step;
    const Signal signal = write_frame(due(schedule.fields));
    if (signal != go_on) return signal;
  }
  if (!due(schedule.rows) || last_row_ == step) return go_on;
  last_row_ = step;
  const suspension::Sample now = suspension_.sample();
  const Signal signal = on_root([&] {
    const Signal found = signal_of(recorder_->take(now));
    if (recorder_->pair()) progress_->note(fmt::format("dz = {:.3f}", axial_distance(now)));
    return found;
  });
  int stop = signal == go_on && signals_->received() ? interrupted : signal;
  fluid::mpi_check(MPI_Allreduce(MPI_IN_PLACE, &stop, 1, MPI_INT, MPI_MAX, suspension_.comm()),
                   "MPI_Allreduce");
  return static_cast<Signal>(stop);
}

// Rank 0 looks at the gaps when they are due. Collective.
Signal Run::watch_gaps() {
  const std::int64_t step = suspension_.steps();
  if (given_.plan.bodies.empty() ||
      (step % gap_interval != 0 && step != given_.schedule.end && !contact_))
    return go_on;
  const std::vector<suspension::Gap> gaps = suspension_.gaps(suspension::kernel_reach);
  return on_root([&] {
    const bool crossed = recorder_->take_gaps(suspension_.time(), gaps);
    return crossed && given_.scenario.run.stop_at_contact ? contact : go_on;
  });
}

// All that is to be seen and written after the step. Collective.
Signal Run::look() {
  const Signal met = watch_gaps();
  if (met == contact && !contact_) {
    contact_ = true;
    contact_reason_ = "surfaces have crossed; run.stop_at_contact = false lets a run go on";
  }
  return std::max(met, record());
}

void Run::check_fluid() {
  if (suspension_.finite()) return;
  throw FluidFailure(
      "its density or velocity is no longer finite: too high a velocity, or a body too stiff");
}

// By the end of the first step every solver has read its options. Collective.
void Run::report_unread_options() {
  for (const std::string& name : petsc_.unread(suspension_.comm())) {
    if (recorder_ && !options_.read_options.contains(name))
      recorder_->warn("[petsc] " + name + ": nothing in this run reads this option of PETSc");
  }
}

// Until the run is over; nothing where the output has failed, of which rank 0 has said why.
std::optional<RunStatus> Run::loop() {
  Signal signal = look();
  while (signal == go_on && suspension_.steps() < given_.schedule.end) {
    suspension_.step();
    if (suspension_.steps() == 1) report_unread_options();
    if (suspension_.steps() % finite_interval == 0) check_fluid();
    signal = look();
    if (progress_) progress_->update(suspension_.time(), suspension_.steps());
  }
  switch (signal) {
    case failed_output:
      return std::nullopt;
    case decided:
      return RunStatus::decided;
    case too_far:
      return RunStatus::stop_distance;
    case contact:
      return RunStatus::contact;
    case interrupted:
      return RunStatus::interrupted;
    case go_on:
      break;
  }
  return RunStatus::finished;
}

RunResult Run::run() {
  const int opened = open();
  if (opened != exit_success) return not_done(opened);
  signals_.emplace();
  start_ = Progress::steady_seconds();
  const auto blew_up = [&](BlowUp blow_up) {
    blow_up.reason += "; `ductile check` tells the margins of stability";
    return finish(RunStatus::blew_up, std::move(blow_up));
  };
  try {
    const std::optional<RunStatus> status = loop();
    return status ? finish(*status, std::nullopt) : not_done(exit_failure);
  } catch (const coupling::BodyFailure& failure) {
    if (failure.step() == 0) report_unread_options();
    if (failure.cause() == coupling::BodyFailure::Cause::boundary) return end_at_wall(failure);
    const auto body = static_cast<std::size_t>(failure.body());
    return blew_up(
        {failure.step(), given_.plan.bodies[body].name, failure.marker(), failure.reason()});
  } catch (const FluidFailure& failure) {
    return blew_up({suspension_.steps(), "", std::nullopt, failure.what()});
  }
}

// The coupler refuses a step before it is begun: there is a state to show.
RunResult Run::end_at_wall(const coupling::BodyFailure& failure) {
  contact_ = true;
  contact_reason_ = fmt::format(
      "body \"{}\", {}; if nothing drives it there it has become unstable: `ductile "
      "check` tells the margins of stability",
      given_.plan.bodies[static_cast<std::size_t>(failure.body())].name, failure.reason());
  return look() == failed_output ? not_done(exit_failure)
                                 : finish(RunStatus::contact, std::nullopt);
}

RunResult Run::finish(RunStatus status, std::optional<BlowUp> blow_up) {
  const double wall_time = Progress::steady_seconds() - start_;
  const std::int64_t steps = blow_up ? blow_up->step : suspension_.steps();  // completed
  std::optional<RunProfile> times;
  if (options_.profile) times = gathered(suspension_.profile(), wall_time, suspension_.comm());
  const std::vector<membrane::SolveStatistics> spent = suspension_.solvers();
  RunResult result;
  result.exit_code = exit_code_of(status);
  result.interrupted = status == RunStatus::interrupted;
  const Signal signal = on_root([&] {
    progress_->finish();
    Summary summary = recorder_->summarise(status, spent);
    if (status == RunStatus::finished && summary.verdict && !summary.verdict->decided()) {
      summary.status = RunStatus::time_limit;
    }
    summary.blow_up = std::move(blow_up);
    summary.contact_reason = contact_reason_;
    summary.time = given_.plan.units.time(steps);
    summary.steps = steps;
    summary.wall_time = wall_time;
    summary.updates_per_second =
        static_cast<double>(given_.plan.node_count()) * static_cast<double>(steps) / wall_time;
    summary.ranks = suspension_.ranks();
    summary.profile = std::move(times);
    summary.versions = versions();
    recorder_->write(summary);
    result.summary = std::move(summary);
    result.samples = std::move(recorder_->samples());
    return go_on;
  });
  return signal == failed_output ? not_done(exit_failure) : std::move(result);
}

}  // namespace

RunResult run_case(const Case& given, const RunOptions& options, MPI_Comm comm) {
  std::optional<Run> run;
  try {
    run.emplace(given, options, comm);
  } catch (const std::invalid_argument& refused) {  // alike on every rank
    if (rank_in(comm) == 0) fmt::print(stderr, "ductile: {}\n", refused.what());
    return not_done(exit_failure);
  }
  try {
    RunResult result = run->run();
    run->view_petsc_log();
    return result;
  } catch (const std::exception& error) {
    // One rank may be alone with this: the others are not to wait for it, nor it for them.
    fmt::print(stderr, "ductile: {}\n", error.what());
    MPI_Abort(comm, exit_failure);
    throw;
  }
}

}  // namespace ductile::drivers
