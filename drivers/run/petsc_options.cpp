#include "run/petsc_options.hpp"

#include <fmt/format.h>
#include <petscsys.h>
#include <petscviewer.h>

#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "ductile/fluid/mpi.hpp"
#include "ductile/membrane/capsule.hpp"
#include "ductile/surface/mesh.hpp"
#include "scenario/errors.hpp"

namespace ductile::drivers {
namespace {

// A slightly inflated sphere in a fluid that lets each vertex drift with its own force.
void take_a_step(const membrane::Scheme& scheme) {
  constexpr double drag = 0.1;
  const surface::Mesh reference = surface::icosphere(2, 4);
  const surface::Mesh inflated = surface::icosphere(2, 4.001);
  membrane::CapsuleOptions capsule_options;
  capsule_options.viscosity = 1;
  capsule_options.integrator = membrane::make_integrator(scheme);
  membrane::Capsule capsule(reference, inflated.vertices, {.k_s = 0.1, .k_a = 0.2},
                            capsule_options);
  std::vector<double> force(capsule.positions().size());
  std::vector<double> velocity(force.size());
  std::vector<double> increment(force.size());
  const auto drift = [](std::span<const double> f, std::span<double> v) {
    for (std::size_t k = 0; k < f.size(); ++k) v[k] = drag * f[k];
  };
  capsule.predict_force(force);
  for (int round = 0; round < capsule.corrections(); ++round) {
    drift(force, velocity);
    capsule.correct_force(velocity, drift, increment);
    for (std::size_t k = 0; k < force.size(); ++k) force[k] += increment[k];
  }
}

}  // namespace

std::vector<std::string> ignored_petsc_sources() {
  std::vector<std::string> found;
  for (const char* variable : {"PETSC_OPTIONS", "PETSC_OPTIONS_YAML"}) {
    if (std::getenv(variable) == nullptr) continue;
    found.emplace_back(variable);
    unsetenv(variable);
  }
  std::vector<std::filesystem::path> files = {".petscrc", "petscrc"};
  if (const char* home = std::getenv("HOME"))
    files.push_back(std::filesystem::path(home) / files[0]);
  for (const std::filesystem::path& file : files) {
    std::error_code error;
    if (std::filesystem::exists(file, error)) found.push_back(file.string());
  }
  return found;
}

PetscOptions::PetscOptions(const std::vector<PetscOption>& options) {
  try {
    for (const auto& [name, value] : options) {
      const std::string key = "-" + name;
      const char* old = nullptr;
      PetscBool there = PETSC_FALSE;
      membrane::petsc_check(PetscOptionsFindPair(nullptr, nullptr, key.c_str(), &old, &there));
      Entry entry{name, std::nullopt};
      if (there == PETSC_TRUE) entry.before = old == nullptr ? "" : old;
      entries_.push_back(std::move(entry));
      membrane::petsc_check(
          PetscOptionsSetValue(nullptr, key.c_str(), value.empty() ? nullptr : value.c_str()));
    }
    // There is no log unless it is begun.
    PetscBool log = PETSC_FALSE;
    membrane::petsc_check(PetscOptionsHasName(nullptr, nullptr, "-log_view", &log));
    if (log == PETSC_TRUE) membrane::petsc_check(PetscLogDefaultBegin());
  } catch (...) {
    restore();
    throw;
  }
}

PetscOptions::~PetscOptions() {
  restore();
}

void PetscOptions::restore() noexcept {
  for (const auto& [name, before] : entries_) {
    const std::string key = "-" + name;
    static_cast<void>(PetscOptionsClearValue(nullptr, key.c_str()));
    if (!before) continue;
    static_cast<void>(
        PetscOptionsSetValue(nullptr, key.c_str(), before->empty() ? nullptr : before->c_str()));
  }
}

void PetscOptions::view_log() const {
  membrane::petsc_check(PetscLogViewFromOptions());
}

std::vector<std::string> PetscOptions::unread(MPI_Comm comm) const {
  std::vector<int> used;
  for (const Entry& entry : entries_) {
    PetscBool read = PETSC_FALSE;
    membrane::petsc_check(PetscOptionsUsed(nullptr, entry.name.c_str(), &read));
    used.push_back(read == PETSC_TRUE ? 1 : 0);
  }
  fluid::mpi_check(MPI_Allreduce(MPI_IN_PLACE, used.data(), static_cast<int>(used.size()), MPI_INT,
                                 MPI_MAX, comm),
                   "MPI_Allreduce");
  std::vector<std::string> names;
  for (std::size_t n = 0; n < used.size(); ++n) {
    if (used[n] == 0) names.push_back(entries_[n].name);
  }
  return names;
}

std::set<std::string> try_petsc_options(const Case& given) {
  std::set<std::string> read;
  if (given.scenario.petsc.empty()) return read;
  try {
    const PetscOptions options(given.scenario.petsc);
    // Where the log is to go is otherwise looked at when the run is over.
    PetscViewer viewer = nullptr;
    membrane::petsc_check(PetscOptionsGetViewer(PETSC_COMM_SELF, nullptr, nullptr, "-log_view",
                                                &viewer, nullptr, nullptr));
    membrane::petsc_check(PetscViewerDestroy(&viewer));
    std::set<std::string_view> tried;
    for (const suspension::BodyPlan& body : given.plan.bodies) {
      const suspension::CapsulePlan* capsule = body.capsule();
      if (capsule == nullptr || !tried.insert(capsule->integrator.name).second) continue;
      try {
        take_a_step(capsule->integrator);
      } catch (const membrane::SolveFailure&) {
        // The options are understood; whether they serve is for the run to tell.
      }
    }
    for (const PetscOption& option : given.scenario.petsc) read.insert(option.name);
    for (const std::string& name : options.unread(MPI_COMM_SELF)) read.erase(name);
  } catch (const membrane::PetscFailure& failure) {
    throw InputError(fmt::format("[petsc]: {}; mend the option or remove it", failure.what()));
  } catch (const std::invalid_argument& refused) {
    throw InputError(fmt::format("[petsc]: {}", refused.what()));
  }
  return read;
}

}  // namespace ductile::drivers
