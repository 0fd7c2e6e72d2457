#include "run/run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "ductile/coupling/coupler.hpp"
#include "ductile/suspension/suspension.hpp"
#include "output/say.hpp"
#include "output/version.hpp"
#include "run/blow_up.hpp"
#include "run/petsc_options.hpp"
#include "run/poll.hpp"
#include "run/progress.hpp"
#include "run/recorder.hpp"
#include "run/root.hpp"
#include "run/watchdog.hpp"
#include "scenario/errors.hpp"

namespace ductile::drivers {
namespace {

constexpr std::int64_t finite_interval = 32;  // steps between two looks at the whole fluid
// Steps between two looks at the gaps: surfaces that approach each other at a Mach number of 0.05
// come nearer by a lattice spacing. A look costs about what a step does at worst.
constexpr std::int64_t gap_interval = 32;

// Why the loop goes on or ends; the largest of all ranks' counts.
enum Signal : int {
  go_on,
  walltime,
  interrupted,
  decided,
  too_far,
  contact,
  blown_up,
  failed_output,
};

Signal signal_of(Recorder::Finding finding) {
  if (finding == Recorder::Finding::too_far) return too_far;
  return finding == Recorder::Finding::decided ? decided : go_on;
}

// What would have ended the run before it was saved, and ends it again.
Signal found_before(const Recorder& recorder, const Case& given) {
  const auto crossed = [](const Contact& contact) { return contact.crossed(); };
  if (given.scenario.run.stop_at_contact && std::ranges::any_of(recorder.contacts().all(), crossed))
    return contact;
  return signal_of(recorder.found());
}

// The state is not finite any more. Thrown on every rank; rank 0 knows of which body, or of the
// fluid.
struct StateFailure : std::runtime_error {
  explicit StateFailure(std::string body_at_fault = "")
      : std::runtime_error(body_at_fault.empty() ? "its density or velocity is no longer finite"
                                                 : "its state is no longer finite"),
        body(std::move(body_at_fault)) {}
  std::string body;
};

/// The body of "state/body/NAME/...", or nothing.
std::string body_of(std::string_view part) {
  constexpr std::string_view before = "state/body/";
  if (!part.starts_with(before)) return "";
  part.remove_prefix(before.size());
  return std::string(part.substr(0, part.find('/')));
}

ExitCode exit_code_of(RunStatus status) {
  switch (status) {
    case RunStatus::contact:
      return exit_contact;
    case RunStatus::blew_up:
      return exit_blow_up;
    case RunStatus::interrupted:
      return exit_interrupted;
    case RunStatus::walltime:
      return exit_walltime;
    default:
      return exit_success;
  }
}

double& program_start() {
  static double seconds = Progress::steady_seconds();
  return seconds;
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
  int take_over();
  std::optional<RunStatus> loop();
  Signal on_root(const std::function<Signal()>& work);
  [[nodiscard]] bool due(double interval) const {
    return Schedule::due(suspension_.steps(), interval) || (interval > 0 && last_);
  }
  Signal write_frame(bool with_fluid);
  Signal record();
  Signal watch_gaps();
  Signal look();
  Signal poll();
  Signal save();
  Signal look_last();
  bool step();
  void check_fluid();
  void report_unread_options();
  Leg leg();
  RunResult end_by_blow_up(BlowUp blow_up);
  RunResult finish(RunStatus status, std::optional<BlowUp> blow_up);

  const Case& given_;
  const RunOptions& options_;
  PetscOptions petsc_;  // before the solvers
  suspension::Suspension suspension_;
  std::optional<Recorder> recorder_;
  std::optional<Progress> progress_;
  std::optional<Poll> poll_;
  std::optional<Watchdog> watchdog_;
  Course course_;      // its legs are rank 0's
  bool last_ = false;  // the run is over: what is to be seen at its end is written now
  int signal_ = 0;     // that has ended the run
  std::string contact_reason_;
  std::int64_t first_step_ = 0;  // of this leg
  double start_ = 0;             // of the loop, by Progress::steady_seconds
};

// Rank 0 does the work, which may fail; every rank learns the outcome.
Signal Run::on_root(const std::function<Signal()>& work) {
  const int done = drivers::on_root(suspension_.comm(), failed_output, [&]() -> int {
    try {
      return work();
    } catch (...) {
      if (progress_) progress_->finish();
      throw;
    }
  });
  if (watchdog_) watchdog_->tick(suspension_.steps());
  return static_cast<Signal>(done);
}

// A refusal to overwrite is the user's to mend; anything else here is the system's.
int Run::open() {
  const int opened = drivers::on_root(suspension_.comm(), exit_failure, [&]() -> int {
    try {
      if (options_.resume) {
        recorder_.emplace(given_, options_.directory, options_.scenario_text, options_.warnings);
      } else {
        recorder_.emplace(given_, options_.directory, options_.force, options_.scenario_text,
                          options_.warnings);
      }
    } catch (const InputError& error) {
      say(stderr, "{}\n", error.what());
      return exit_bad_input;
    }
    // Under mpirun no rank sees the terminal; who starts it there says so.
    const bool terminal = isatty(STDERR_FILENO) != 0 || std::getenv("DUCTILE_LIVE") != nullptr;
    progress_.emplace(given_.plan.units.time(given_.schedule.end), given_.plan.node_count(), stderr,
                      terminal, Progress::steady_seconds);
    return exit_success;
  });
  return opened == exit_success && options_.resume ? take_over() : opened;
}

// The state of the checkpoint that rank 0 has found.
int Run::take_over() {
  const int found = drivers::on_root(suspension_.comm(), exit_failure, [&]() -> int {
    return recorder_->checkpoint() != nullptr ? exit_success : -1;
  });
  if (found < 0) return exit_success;
  try {
    suspension_.load([&](std::string_view name, std::span<double> numbers) {
      recorder_->checkpoint()->read("state/" + std::string(name), numbers);
    });
  } catch (const std::exception& error) {  // a file's, or what a solver refuses to take
    if (recorder_) say(stderr, "ductile: {}\n", error.what());
    return exit_failure;
  }
  std::array<std::int64_t, 2> last{};
  if (recorder_) {
    course_ = recorder_->course();
    last = {course_.last_row, course_.last_frame};
    say(stderr, "goes on from t = {:.6g}, step {}, of {}\n", suspension_.time(),
        suspension_.steps(), recorder_->checkpoint()->path().string());
    recorder_->close_checkpoint();
    if (suspension_.steps() > given_.schedule.end) {
      recorder_->warn(fmt::format("the run was at t = {:.6g} already, beyond its time limit",
                                  suspension_.time()));
    }
  }
  fluid::mpi_check(MPI_Bcast(last.data(), 2, MPI_INT64_T, 0, suspension_.comm()), "MPI_Bcast");
  course_.last_row = last[0];
  course_.last_frame = last[1];
  return exit_success;
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
  if ((due(schedule.surfaces) || due(schedule.fields)) && course_.last_frame != step) {
    course_.last_frame = step;
    const Signal signal = write_frame(due(schedule.fields));
    if (signal != go_on) return signal;
  }
  if (!due(schedule.rows) || course_.last_row == step) return go_on;
  course_.last_row = step;
  const suspension::Sample now = suspension_.sample();
  return on_root([&] {
    const Signal found = signal_of(recorder_->take(now));
    if (recorder_->pair()) progress_->note(fmt::format("dz = {:.3f}", axial_distance(now)));
    return found;
  });
}

// Rank 0 looks at the gaps when they are due. Collective.
Signal Run::watch_gaps() {
  if (given_.plan.bodies.empty() || (suspension_.steps() % gap_interval != 0 && !last_))
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
  return std::max(met, record());
}

// What the run does because of the time, or of somebody's wish. Collective.
Signal Run::poll() {
  const Poll::Finding found = poll_->after_step();
  signal_ = found.signal;
  if (found.signal != 0) return interrupted;
  if (found.walltime) return walltime;
  return found.checkpoint ? save() : go_on;
}

// Keeps the state. Collective. Throws StateFailure.
Signal Run::save() {
  const double begun = Progress::steady_seconds();
  const Leg now = leg();
  std::optional<NewCheckpoint> checkpoint;
  Signal signal = on_root([&] {
    checkpoint.emplace(recorder_->directory().checkpoint());
    Course course = course_;
    course.legs.push_back(now);
    recorder_->save(*checkpoint, course);
    return go_on;
  });
  if (signal != go_on) return signal;
  // One rank alone hears of what keeps it from being written.
  std::string refused;
  std::optional<std::string> not_finite;
  try {
    suspension_.save([&](std::string_view name, std::span<const double> numbers) {
      checkpoint->put("state/" + std::string(name), numbers);
    });
  } catch (const NotFinite& part) {
    not_finite = body_of(part.what());
  } catch (const std::exception& error) {
    refused = error.what();
  }
  signal = on_root([&] {
    if (not_finite) return blown_up;
    if (!refused.empty()) throw OutputError(refused);
    checkpoint->commit(recorder_->directory().checkpoint_before());
    return go_on;
  });
  poll_->checkpoint_written(begun);
  if (signal == blown_up) throw StateFailure(not_finite.value_or(""));
  return signal;
}

// The run is over: a checkpoint of it as any longer one would have it, then what is seen at its end
// alone. Collective.
Signal Run::look_last() {
  const Signal saved = save();
  if (saved != go_on) return saved;
  last_ = true;
  return look();
}

Leg Run::leg() {
  const double wall_time = Progress::steady_seconds() - start_;
  Leg leg{first_step_, suspension_.steps(), suspension_.ranks(), wall_time, {}};
  if (const auto times = gathered(suspension_.profile(), wall_time, suspension_.comm())) {
    for (const RunProfile::Rank& rank : times->ranks)
      std::ranges::transform(leg.core_time, rank, leg.core_time.begin(), std::plus<>());
  }
  return leg;
}

void Run::check_fluid() {
  if (!suspension_.finite()) throw StateFailure();
}

// By the end of the first step every solver has read its options. Collective.
void Run::report_unread_options() {
  for (const std::string& name : petsc_.unread(suspension_.comm())) {
    if (recorder_ && !options_.read_options.contains(name))
      recorder_->warn("[petsc] " + name + ": nothing in this run reads this option of PETSc");
  }
}

// False if a body has come to a wall: the coupler refuses such a step before it is begun, and there
// is a state to show.
bool Run::step() {
  try {
    suspension_.step();
  } catch (const coupling::BodyFailure& failure) {
    if (failure.cause() != coupling::BodyFailure::Cause::boundary) throw;
    if (failure.step() == first_step_) report_unread_options();
    contact_reason_ = fmt::format(
        "body \"{}\", {}; if nothing drives it there it has become unstable: `ductile "
        "check` tells the margins of stability",
        given_.plan.bodies[static_cast<std::size_t>(failure.body())].name, failure.reason());
    return false;
  }
  watchdog_->tick(suspension_.steps());
  return true;
}

// Until the run is over; nothing where the output has failed, of which rank 0 has said why.
std::optional<RunStatus> Run::loop() {
  Signal signal = look();
  if (signal == go_on && options_.resume) {
    signal = on_root([&] { return found_before(*recorder_, given_); });
  }
  if (signal == go_on) signal = poll();
  while (signal == go_on && suspension_.steps() < given_.schedule.end) {
    if (!step()) {
      signal = contact;
      break;
    }
    if (suspension_.steps() == first_step_ + 1) report_unread_options();
    if (suspension_.steps() % finite_interval == 0) check_fluid();
    signal = look();
    if (progress_) progress_->update(suspension_.time(), suspension_.steps());
    if (signal == go_on) signal = poll();
  }
  // A run that goes on at once has nothing to see at its end.
  const bool goes_on = signal == interrupted || signal == walltime;
  if (signal != failed_output) {
    if (signal == contact && contact_reason_.empty())
      contact_reason_ = "surfaces have crossed; run.stop_at_contact = false lets a run go on";
    if ((goes_on ? save() : look_last()) == failed_output) signal = failed_output;
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
    case walltime:
      return RunStatus::walltime;
    case blown_up:  // is thrown
    case go_on:
      break;
  }
  return RunStatus::finished;
}

RunResult Run::run() {
  const int opened = open();
  if (opened != exit_success) return not_done(opened);
  start_ = Progress::steady_seconds();
  first_step_ = suspension_.steps();
  constexpr double minute = 60;
  poll_.emplace(suspension_.comm(), Progress::steady_seconds, program_start(),
                options_.max_walltime, minute * given_.scenario.run.checkpoint_every);
  // A rank alone waits for nobody. The line goes past all that the other thread may be at, and so
  // does the end: MPI may be what hangs, and mpirun ends the others.
  const double patience = suspension_.ranks() > 1 ? given_.scenario.run.patience : 0;
  watchdog_.emplace(minute * patience, [this, patience](std::int64_t step) {
    const std::string line = fmt::format(
        "ductile: rank {} has waited for another one since step {}, for the {:g} minutes of "
        "run.patience: that one is stopped, or waits for a disk; `ductile resume` goes on from the "
        "last checkpoint\n",
        suspension_.rank(), step, patience);
    static_cast<void>(write(STDERR_FILENO, line.data(), line.size()) > 0);
    std::_Exit(exit_failure);
  });
  try {
    const std::optional<RunStatus> status = loop();
    return status ? finish(*status, std::nullopt) : not_done(exit_failure);
  } catch (const coupling::BodyFailure& failure) {
    if (failure.step() == first_step_) report_unread_options();
    const auto body = static_cast<std::size_t>(failure.body());
    return end_by_blow_up({failure.step(),
                           given_.plan.bodies[body].name,
                           failure.marker(),
                           failure.reason(),
                           {},
                           {}});
  } catch (const StateFailure& failure) {
    return end_by_blow_up(
        {suspension_.steps(), failure.body, std::nullopt, failure.what(), {}, {}});
  }
}

// The state as it is, for people to look at; the checkpoints stay what they were.
RunResult Run::end_by_blow_up(BlowUp blow_up) {
  const suspension::Sample sample = suspension_.sample();
  const std::vector<suspension::SurfaceState> surfaces = suspension_.surfaces();
  const suspension::FluidState fluid = suspension_.fields();
  const Signal written = on_root([&] {
    blow_up = explained(std::move(blow_up), given_, surfaces, fluid, recorder_->contacts(),
                        recorder_->warnings());
    recorder_->write_wreck(sample, surfaces, fluid);
    return go_on;
  });
  return written == failed_output ? not_done(exit_failure)
                                  : finish(RunStatus::blew_up, std::move(blow_up));
}

RunResult Run::finish(RunStatus status, std::optional<BlowUp> blow_up) {
  const double wall_time = Progress::steady_seconds() - start_;
  const std::int64_t steps = blow_up ? blow_up->step : suspension_.steps();  // completed
  const Leg now = leg();
  std::optional<RunProfile> times;
  if (options_.profile) times = gathered(suspension_.profile(), wall_time, suspension_.comm());
  const std::vector<membrane::SolveStatistics> spent = suspension_.solvers();
  RunResult result;
  result.exit_code = exit_code_of(status);
  result.interrupted = status == RunStatus::interrupted || status == RunStatus::walltime;
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
    summary.signal = signal_;
    summary.legs = course_.legs;
    summary.legs.push_back(now);
    for (const Leg& leg : summary.legs) summary.wall_time += leg.wall_time;
    summary.updates_per_second = static_cast<double>(given_.plan.node_count()) *
                                 static_cast<double>(steps) / summary.wall_time;
    summary.ranks = suspension_.ranks();
    summary.profile = std::move(times);
    summary.versions = versions();
    recorder_->write(summary);
    result.summary = std::move(summary);
    result.samples = std::move(recorder_->samples());
    result.log = recorder_->log();
    return go_on;
  });
  return signal == failed_output ? not_done(exit_failure) : std::move(result);
}

}  // namespace

void start_clock() {
  program_start();
}

RunResult run_case(const Case& given, const RunOptions& options, MPI_Comm comm) {
  std::optional<Run> run;
  try {
    run.emplace(given, options, comm);
  } catch (const std::invalid_argument& refused) {  // alike on every rank
    if (rank_in(comm) == 0) say(stderr, "ductile: {}\n", refused.what());
    return not_done(exit_failure);
  }
  try {
    RunResult result = run->run();
    run->view_petsc_log();
    return result;
  } catch (const std::exception& error) {
    // One rank may be alone with this: the others are not to wait for it, nor it for them.
    say(stderr, "ductile: {}\n", error.what());
    MPI_Abort(comm, exit_failure);
    throw;
  }
}

}  // namespace ductile::drivers
