#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "commands/check.hpp"
#include "commands/compare.hpp"
#include "commands/program.hpp"
#include "commands/run.hpp"
#include "ductile/membrane/integrator.hpp"
#include "scenario/errors.hpp"
#include "scenario/pairs.hpp"
#include "scenario/writer.hpp"
#include "support/temporary_directory.hpp"

namespace ductile::drivers {
namespace {

const std::string scenario_dir = DUCTILE_SCENARIO_DIR;

/// What a command that runs one case makes of the arguments.
SingleRun::Request request(const std::vector<std::string>& arguments) {
  const CommandLine line(arguments);
  return dynamic_cast<SingleRun&>(*line.command()).prepare();
}

Scenario scenario(const std::vector<std::string>& arguments) {
  return request(arguments).given.scenario;
}

CompareCommand::Request comparison(const std::vector<std::string>& arguments) {
  const CommandLine line(arguments);
  return dynamic_cast<CompareCommand&>(*line.command()).prepare();
}

std::string refused(const std::vector<std::string>& arguments) {
  try {
    const CommandLine line(arguments);
    if (auto* single = dynamic_cast<SingleRun*>(line.command()))
      static_cast<void>(single->prepare());
    if (auto* compare = dynamic_cast<CompareCommand*>(line.command()))
      static_cast<void>(compare->prepare());
    if (auto* check = dynamic_cast<CheckCommand*>(line.command()))
      static_cast<void>(check->prepare());
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(CommandLine, PairIsItsScenarioFileWithTheSameValues) {
  ASSERT_EQ(pair_scenarios().size(), 7U);
  for (const auto& [name, text] : pair_scenarios()) {
    const Scenario pair =
        scenario({"pair", std::string(name), "--x-lag", "0.1", "--nodes", "48", "--tau", "0.9",
                  "--length", "10", "--time-limit", "7", "--set", "membrane.mobility=0"});
    const Scenario run = scenario({"run", scenario_dir + "/" + std::string(name) + ".toml", "--set",
                                   "body.lag.x=0.1", "--set=channel.nodes=48", "--set",
                                   "fluid.tau=0.9", "--set", "channel.length=10", "--set",
                                   "run.time_limit=7", "--set", "membrane.mobility=0"});
    EXPECT_EQ(pair, run) << name;
    EXPECT_EQ(pair.bodies.at(1).x, 0.1);
    EXPECT_EQ(resolved_toml(pair), resolved_toml(run));
  }
}

// Fig. 2 of the paper.
TEST(CommandLine, PairsAreThePapers) {
  struct Particle {
    BodyKind kind;
    std::string shape;
    double laplace;
  };
  constexpr auto capsule = BodyKind::capsule;
  const std::string sphere = "sphere";
  const std::string cell = "biconcave";
  const std::vector<std::pair<std::string, std::array<Particle, 2>>> table = {
      {"M1", {{{capsule, sphere, 10}, {capsule, sphere, 10}}}},
      {"M2", {{{capsule, sphere, 100}, {capsule, sphere, 100}}}},
      {"M3", {{{BodyKind::rigid, sphere, 0}, {BodyKind::rigid, sphere, 0}}}},
      {"B1", {{{capsule, sphere, 10}, {capsule, cell, 10}}}},
      {"B2", {{{capsule, sphere, 100}, {capsule, cell, 100}}}},
      {"B3", {{{capsule, sphere, 10}, {capsule, sphere, 100}}}},
      {"B4", {{{capsule, sphere, 100}, {capsule, sphere, 10}}}}};
  for (const auto& [name, particles] : table) {
    for (const char* x_lag : {"-0.4", "-0.2", "0", "0.2", "0.4"}) {
      const Scenario s = scenario({"pair", name, "--x-lag", x_lag});
      EXPECT_EQ(s.name, name);
      EXPECT_EQ(s.channel.reynolds, 10);
      ASSERT_EQ(s.bodies.size(), 2U);
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(s.bodies[i].kind, particles[i].kind);
        EXPECT_EQ(s.bodies[i].shape, particles[i].shape);
        EXPECT_EQ(s.bodies[i].laplace, particles[i].laplace);
        EXPECT_EQ(s.bodies[i].radius, 0.4);
        EXPECT_EQ(s.bodies[i].y, 0);
        EXPECT_EQ(s.bodies[i].rotation_angle, 0);
      }
      EXPECT_EQ(s.bodies[0].x, 0.2);
      EXPECT_EQ(s.bodies[1].x, std::stod(x_lag));
      EXPECT_EQ(s.bodies[0].z - s.bodies[1].z, 1);
    }
  }
}

TEST(CommandLine, DirectoriesAreNamedForTheRun) {
  EXPECT_EQ(request({"pair", "M1", "--x-lag", "-0.20"}).directory, "runs/M1_x-lag_-0.2");
  EXPECT_EQ(request({"run", scenario_dir + "/rigid.toml"}).directory, "runs/rigid");
  EXPECT_EQ(request({"pair", "M1", "--x-lag", "0", "-o", "some/where"}).directory, "some/where");
  // One pair at two resolutions.
  EXPECT_EQ(request({"pair", "M1", "--x-lag", "0", "--nodes", "24"}).directory,
            "runs/M1_x-lag_0_nodes_24");
  EXPECT_EQ(request({"run", scenario_dir + "/rigid.toml", "--set", "body.particle.x=0.10", "--set",
                     "fluid.collision=trt", "--set", "channel.gravity=[-1, 0, 1.5]", "--set",
                     "run.time_limit=1", "--set", "output.every=1", "--set", "name=sphere"})
                .directory,
            "runs/sphere_gravity_-1.0-0.0-1.5_collision_trt_particle-x_0.1");
  std::vector<std::string> many = {"run", scenario_dir + "/rigid.toml"};
  for (const std::string key :
       {"channel.reynolds", "fluid.magic", "membrane.theta", "membrane.mobility",
        "membrane.bending", "membrane.area_ratio", "rigid.retraction", "rigid.memory",
        "body.particle.x", "body.particle.y", "body.particle.z", "body.particle.rotation_angle"}) {
    many.insert(many.end(),
                {"--set", key + (key == "membrane.theta" ? "=0.6000000001" : "=0.0500000001")});
  }
  EXPECT_NE(refused(many).find("too long for a directory's name"), std::string::npos)
      << refused(many);
}

// Whatever file and --set say of single bodies; rigid ones have no integrator.
TEST(CommandLine, CompareGivesAllCapsulesEachIntegrator) {
  const std::string file = DUCTILE_SOURCE_DIR "/tests/drivers/three_kinds.toml";
  const CompareCommand::Request asked =
      comparison({"compare", file, "--integrators", "adams-bashforth,explicit-euler", "--set",
                  "body.cell.integrator=adams-bashforth", "--set", "run.time_limit=0.1"});
  const Scenario plain = scenario({"run", file, "--set", "body.cell.integrator=adams-bashforth",
                                   "--set", "run.time_limit=0.1"});
  EXPECT_EQ(asked.directory, "runs/three-kinds_cell-integrator_adams-bashforth_compare");
  ASSERT_EQ(asked.cases.size(), 2U);
  EXPECT_EQ(asked.cases[0].first, "adams-bashforth");
  EXPECT_EQ(asked.cases[1].first, "explicit-euler");
  for (const auto& [name, compared] : asked.cases) {
    const Scenario& scenario = compared.scenario;
    EXPECT_EQ(scenario.run.time_limit, 0.1);
    for (const BodyOptions& body : scenario.bodies) {
      if (body.kind == BodyKind::rigid) continue;
      EXPECT_EQ(body.membrane.integrator, name) << body.name;
    }
    // Nothing else differs from the scenario itself.
    Scenario same = scenario;
    same.membrane.integrator = plain.membrane.integrator;
    for (std::size_t b = 0; b < same.bodies.size(); ++b)
      same.bodies[b].membrane.integrator = plain.bodies[b].membrane.integrator;
    EXPECT_EQ(same, plain);
  }
}

TEST(CommandLine, CompareRefusesWhatItCannotCompare) {
  const std::string file = scenario_dir + "/quickstart.toml";
  const auto with = [&file](const std::string& names) {
    return refused({"compare", file, "--integrators", names});
  };
  EXPECT_EQ(with("explicit-euler,adams-bashfort"),
            "--integrators explicit-euler,adams-bashfort: unknown integrator \"adams-bashfort\"; "
            "did you mean \"adams-bashforth\"?");
  std::string known;
  for (const std::string_view name : membrane::integrator_names())
    known += (known.empty() ? "" : ", ") + std::string(name);
  EXPECT_EQ(with("explicit-euler,,"),
            "--integrators explicit-euler,,: unknown integrator \"\"; "
            "the integrators are " +
                known);
  EXPECT_EQ(with("explicit-euler,adams-bashforth,explicit-euler"),
            "--integrators explicit-euler,adams-bashforth,explicit-euler: explicit-euler is there "
            "twice");
  EXPECT_EQ(with("explicit-euler"),
            "--integrators explicit-euler: name at least two, with commas between: the integrators "
            "are " +
                known);
  EXPECT_EQ(refused({"compare", file}),
            "ductile compare: --integrators is required; see ductile compare --help");
  const std::string rigid = scenario_dir + "/rigid.toml";
  EXPECT_EQ(refused({"compare", rigid, "--integrators", "explicit-euler,adams-bashforth"}),
            rigid + ": has no capsule, and nothing else has a membrane to advance");
  // A mistake in the file is named before anything is run.
  EXPECT_EQ(refused({"compare", file, "--integrators", "explicit-euler,adams-bashforth", "--set",
                     "body.lag.laplace=x"}),
            "--set body.lag.laplace=x: must be a number from 0 to 10000000");
}

TEST(CommandLine, ProfileIsAskedFor) {
  const auto profiled = [](const std::vector<std::string>& arguments) {
    const CommandLine line(arguments);
    return dynamic_cast<SingleRun&>(*line.command()).profile();
  };
  EXPECT_FALSE(profiled({"run", scenario_dir + "/rigid.toml"}));
  EXPECT_TRUE(profiled({"run", scenario_dir + "/rigid.toml", "--profile"}));
  EXPECT_TRUE(profiled({"pair", "M1", "--x-lag", "0", "--profile"}));
}

TEST(CommandLine, AFilledDirectoryIsLeftAloneUnlessForced) {
  const testing_support::TemporaryDirectory temporary;
  const std::filesystem::path& directory = temporary.path();
  std::ofstream(directory / "trajectory.csv") << "precious";
  const std::vector<std::string> arguments = {"pair", "M1", "--x-lag",
                                              "0",    "-o", directory.string()};
  EXPECT_EQ(refused(arguments),
            directory.string() +
                ": is not empty: add --force to replace the run in it, or choose another with -o");
  std::vector<std::string> forced = arguments;
  forced.emplace_back("--force");
  EXPECT_EQ(request(forced).directory, directory);
  const std::string file = (directory / "trajectory.csv").string();
  EXPECT_EQ(refused({"pair", "M1", "--x-lag", "0", "-o", file}),
            file + ": is not a directory: choose another with -o");
  std::filesystem::remove_all(directory);
  EXPECT_EQ(refused(arguments), "");
  EXPECT_FALSE(std::filesystem::exists(directory));
  // What a run leaves that was killed before it began is no run; other files are somebody's.
  std::filesystem::create_directories(directory);
  for (const char* trace : {"lock.part", "lock", "scenario.toml.part"}) {
    std::ofstream(directory / trace) << "half of";
    std::ofstream(directory / "log.txt") << "of this run";
    EXPECT_EQ(refused(arguments), "") << trace;
    std::filesystem::remove(directory / trace);
    EXPECT_NE(refused(arguments), "") << "a log of another kind, without " << trace;
  }
  std::filesystem::remove(directory / "log.txt");
  std::ofstream(directory / "thesis.part") << "no run's";
  EXPECT_NE(refused(arguments), "");
}

TEST(CommandLine, MistakesGetOneLine) {
  EXPECT_EQ(refused({}), "ductile: no command given; see ductile --help");
  EXPECT_EQ(refused({"chek", "x"}), "ductile chek: not understood; did you mean \"check\"?");
  EXPECT_EQ(refused({"pair", "M1", "--x-lag", "0", "--node", "24"}),
            "ductile pair --node: not understood; did you mean \"--nodes\"?");
  EXPECT_EQ(refused({"pair", "m3", "--x-lag", "0"}),
            "ductile pair m3: unknown pair; did you mean \"M3\"?");
  EXPECT_EQ(refused({"pair", "quick", "--x-lag", "0"}),
            "ductile pair quick: unknown pair; the pairs are M1, M2, M3, B1, B2, B3, B4");
  EXPECT_EQ(refused({"pair", "M1"}), "ductile pair: --x-lag is required; see ductile pair --help");
  EXPECT_EQ(refused({"run"}), "ductile run: FILE is required; see ductile run --help");
  EXPECT_EQ(refused({"pair", "M1", "--x-lag", "left"}), "--x-lag left: must be a number");
  EXPECT_EQ(refused({"pair", "M1", "--x-lag", "0", "--nodes", "3"}),
            "--nodes 3: must be a whole number from 8 to 4096");
  EXPECT_EQ(refused({"check", scenario_dir + "/M1.toml", "--set", "nodes"}),
            "--set nodes: must be KEY=VALUE, such as --set channel.nodes=48 or --set "
            "body.lag.x=0.1");
  EXPECT_EQ(refused({"pair", "M1", "--x-lag", "0.1", "--set", "body.lag.x=0.2"}),
            "--x-lag 0.1 and --set body.lag.x=0.2: give body.lag.x once");
  // One command, and no option without its value.
  EXPECT_EQ(refused({"check", "a.toml", "run", "a.toml"}),
            "ductile check run: not understood; see ductile check --help");
  EXPECT_EQ(refused({"run", "a.toml", "--max-walltime", ""}),
            "ductile run: --max-walltime is empty: give it a value, or leave it out");
  EXPECT_EQ(refused({"campaign", "runs", "--case", ""}),
            "ductile campaign: --case is empty: give it a value, or leave it out");
  EXPECT_EQ(refused({"check", ""}),
            "ductile check: FILE is empty: give it a value, or leave it out");
  EXPECT_EQ(refused({"check", "absent.toml"}),
            "absent.toml: cannot be read: No such file or directory");
}

TEST(CommandLine, PetscOptionsAreGivenAsToPetsc) {
  const std::vector<std::string> run = {"run", scenario_dir + "/rigid.toml"};
  const auto with = [&](const std::string& options) {
    std::vector<std::string> arguments = run;
    arguments.insert(arguments.end(), {"--petsc", options});
    return arguments;
  };
  const std::vector<PetscOption> expected = {
      {"log_view", ""}, {"membrane_ksp_rtol", "-1e-3"}, {"membrane_ksp_type", "cg"}};
  EXPECT_EQ(scenario(with("-membrane_ksp_type cg -membrane_ksp_rtol -1e-3 -log_view")).petsc,
            expected);
  EXPECT_EQ(refused(with("membrane_ksp_type cg")),
            "--petsc \"membrane_ksp_type cg\": membrane_ksp_type is neither an option nor an "
            "option's value: write as for PETSc, such as --petsc \"-membrane_ksp_type bcgs "
            "-log_view\"");
}

TEST(CommandLine, HelpAndVersionArePrinted) {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"--help"}, {"run", "--help"}, {"pair", "-h"}}) {
    const CommandLine help(arguments);
    EXPECT_EQ(help.command(), nullptr);
    EXPECT_NE(help.text().find("Exit codes: 0 success"), std::string::npos);
  }
  EXPECT_NE(CommandLine({"pair", "--help"}).text().find("--x-lag"), std::string::npos);
  const std::string version = CommandLine({"--version"}).text();
  for (const char* part : {"ductile ", "\ncompiler ", "\nMPI ", "\nPETSc 3.", "\nHDF5 1.",
                           "\nEigen 3.", "\ntoml++ ", "\nCLI11 ", "\nfmt "})
    EXPECT_NE(version.find(part), std::string::npos) << part << " is not in\n" << version;
}

}  // namespace
}  // namespace ductile::drivers
