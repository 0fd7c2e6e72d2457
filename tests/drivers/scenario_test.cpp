#include "scenario/scenario.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "input_support.hpp"
#include "scenario/errors.hpp"
#include "scenario/writer.hpp"

namespace ductile::drivers {
namespace {

const std::filesystem::path scenario_dir = DUCTILE_SCENARIO_DIR;

Scenario read(std::string_view text, const std::string& file,
              const std::vector<Override>& overrides = {}) {
  return parse_case(text, file, overrides).scenario;
}

Scenario load(const std::filesystem::path& file) {
  return load_case(file).scenario;
}

std::string contents(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<std::filesystem::path> scenario_files() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(scenario_dir))
    if (entry.path().extension() == ".toml") files.push_back(entry.path());
  return files;
}

TEST(Scenario, EmptyFileGetsEveryDefault) {
  const Scenario s = read("", "some/where/my case.toml");
  EXPECT_EQ(s.name, "my-case");
  EXPECT_EQ(s.channel.nodes, 36);
  EXPECT_EQ(s.channel.walls, fluid::Boundary::halfway);
  EXPECT_EQ(s.channel.length, 12);
  EXPECT_EQ(s.channel.half_width_y, 1);
  EXPECT_EQ(s.channel.reynolds, 10);
  EXPECT_EQ(s.channel.start, suspension::Start::developed);
  EXPECT_EQ(s.fluid.tau, 1);
  EXPECT_EQ(s.fluid.collision, fluid::Collision::bgk);
  EXPECT_EQ(s.fluid.magic, 3.0 / 16.0);
  EXPECT_EQ(s.fluid.storage, fluid::Precision::single_precision);
  EXPECT_EQ(s.fluid.arithmetic, fluid::Precision::single_precision);
  EXPECT_EQ(s.membrane.law, membrane::StrainLaw::skalak);
  EXPECT_EQ(s.membrane.area_ratio, 2);
  EXPECT_EQ(s.membrane.bending, 2.87e-3);
  EXPECT_EQ(s.membrane.mobility, 1e-3);
  EXPECT_EQ(s.membrane.edge, 1.2);
  EXPECT_EQ(s.membrane.integrator, "explicit-euler");
  EXPECT_EQ(s.rigid.iterations, 5);
  EXPECT_EQ(s.rigid.memory, 0);
  EXPECT_EQ(s.rigid.interior, suspension::Interior::fluid);
  EXPECT_EQ(s.run.time_limit, 60);
  EXPECT_EQ(s.run.stop_distance, 10);
  EXPECT_TRUE(s.run.until_decided);
  EXPECT_EQ(s.output.every, 0.05);
  EXPECT_EQ(s.output.surfaces_every, 0.5);
  EXPECT_EQ(s.output.field_every, 0);
  EXPECT_TRUE(s.bodies.empty());
}

TEST(Scenario, BodiesTakeWhatTheirTablesSay) {
  const Scenario s = read(R"(
[membrane]
mobility = 0
edge = 0.8
[rigid]
iterations = 3
[[body]]
laplace = 10
x = 0.3
edge = 1.0
law = "neo-hookean"
[[body]]
name = "ball"
kind = "rigid"
z = 4
density_ratio = 2.5
edge = 0.7
[[body]]
laplace = 20
shape = "biconcave"
z = -4
rotation_axis = [1, 0, 0]
rotation_angle = 90
)",
                          "case.toml");
  ASSERT_EQ(s.bodies.size(), 3U);
  EXPECT_EQ(s.bodies[0].name, "body1");
  EXPECT_EQ(s.bodies[0].x, 0.3);
  EXPECT_EQ(s.bodies[0].radius, 0.4);
  EXPECT_EQ(s.bodies[0].membrane.mobility, 0);
  EXPECT_EQ(s.bodies[0].membrane.edge, 1.0);
  EXPECT_EQ(s.bodies[0].membrane.law, membrane::StrainLaw::neo_hookean);
  EXPECT_EQ(s.bodies[1].name, "ball");
  EXPECT_EQ(s.bodies[1].kind, BodyKind::rigid);
  EXPECT_EQ(s.bodies[1].density_ratio, 2.5);
  EXPECT_EQ(s.bodies[1].rigid.iterations, 3);
  EXPECT_EQ(s.bodies[1].rigid.edge, 0.7);
  EXPECT_EQ(s.bodies[2].name, "body3");
  EXPECT_EQ(s.bodies[2].shape, "biconcave");
  EXPECT_EQ(s.bodies[2].membrane.edge, 0.8);
  EXPECT_EQ(s.bodies[2].membrane.law, membrane::StrainLaw::skalak);
  EXPECT_EQ(s.bodies[2].rotation_axis, (std::array<double, 3>{1, 0, 0}));
  EXPECT_EQ(s.bodies[2].rotation_angle, 90);
}

TEST(Scenario, OverridesReplaceAndAddValuesInTheirOrder) {
  const Scenario s = read(
      pair_text, "case.toml",
      {set("channel.nodes", "48"), set("body.lag.x", "0.1"), set("channel.nodes", "40"),
       set("channel.walls", "regularized"), set("name", "other"), set("body.lead.mobility", "0"),
       set("channel.gravity", "[0, 1, -2.5]"), set("run.until_decided", "false")});
  EXPECT_EQ(s.channel.nodes, 40);
  EXPECT_EQ(s.channel.walls, fluid::Boundary::regularized);
  EXPECT_EQ(s.name, "other");
  EXPECT_EQ(s.bodies[1].x, 0.1);
  EXPECT_EQ(s.bodies[0].membrane.mobility, 0);
  EXPECT_EQ(s.bodies[1].membrane.mobility, 1e-3);
  EXPECT_EQ(s.channel.gravity, (std::array<double, 3>{0, 1, -2.5}));
  EXPECT_FALSE(s.run.until_decided);
}

TEST(Scenario, OverridesReachBodiesWithoutANameByTheirNumber) {
  const Scenario s = read("[[body]]\nlaplace = 10\n", "case.toml", {set("body.body1.x", "0.25")});
  EXPECT_EQ(s.bodies[0].x, 0.25);
}

TEST(Scenario, ArithmeticFollowsStorageUnlessItIsGiven) {
  const auto arithmetic = [](const std::string& text) { return read(text, "c").fluid.arithmetic; };
  EXPECT_EQ(arithmetic("fluid.storage = \"double\"\n"), fluid::Precision::double_precision);
  EXPECT_EQ(arithmetic("fluid.storage = \"single\"\n"), fluid::Precision::single_precision);
  EXPECT_EQ(arithmetic("fluid.arithmetic = \"double\"\n"), fluid::Precision::double_precision);
}

TEST(Scenario, FluidIsIncompressibleWhereAllBodiesGoAlongUnlessItIsGiven) {
  using fluid::Equilibrium;
  const auto equilibrium = [](const std::string& text) {
    return read(text, "c").fluid.equilibrium;
  };
  EXPECT_EQ(equilibrium(""), Equilibrium::incompressible);
  EXPECT_EQ(equilibrium("fluid.frame = \"bodies\"\n"), Equilibrium::incompressible);
  EXPECT_EQ(equilibrium("fluid.equilibrium = \"compressible\"\n"), Equilibrium::compressible);
  for (const char* other : {"fluid.frame = \"walls\"\n", "channel.reynolds = 0.0\n",
                            "channel.gravity = [0.0, 0.0, -1.0]\n",
                            "channel.side_walls = false\nchannel.wall_velocity = [-1.0, 1.0]\n"}) {
    EXPECT_EQ(equilibrium(other), Equilibrium::compressible) << other;
    EXPECT_EQ(equilibrium(std::string("fluid.equilibrium = \"incompressible\"\n") + other),
              Equilibrium::incompressible)
        << other;
  }
}

// What is felt can be said to be, of all bodies and of one.
TEST(Scenario, ARetractionMayBeFelt) {
  const std::string capsule = "[[body]]\nlaplace = 10\n";
  const auto retraction = [](const std::string& text) {
    return read(text, "c").bodies.at(0).membrane.retraction;
  };
  const auto felt = retraction(capsule);
  ASSERT_TRUE(felt.has_value());
  EXPECT_GT(*felt, 0.4);
  EXPECT_EQ(retraction("membrane.retraction = \"felt\"\n" + capsule), felt);
  EXPECT_EQ(retraction("membrane.retraction = 0.2\n" + capsule), 0.2);
  EXPECT_EQ(retraction("membrane.retraction = 0.2\n" + capsule + "retraction = \"felt\"\n"), felt);
  const Scenario s = read(capsule, "c");
  EXPECT_NE(resolved_toml(s).find("retraction = \"felt\""), std::string::npos);
}

TEST(Scenario, StopDistanceFollowsAShortChannel) {
  EXPECT_EQ(read("[channel]\nlength = 8\n", "c").run.stop_distance, 6);
  EXPECT_EQ(read("[channel]\nlength = 3\n", "c").run.stop_distance, 1.5);
  EXPECT_EQ(read("[channel]\nlength = 30\n", "c").run.stop_distance, 10);
  EXPECT_EQ(read("[channel]\nlength = 8\n[run]\nstop_distance = 7\n", "c").run.stop_distance, 7);
}

TEST(Scenario, ResolvedFileGivesTheIdenticalScenario) {
  for (const auto& file : scenario_files()) {
    const Scenario scenario = load(file);
    const std::string resolved = resolved_toml(scenario);
    const Scenario again = read(resolved, "scenario.toml");
    EXPECT_EQ(again, scenario) << file;
    EXPECT_EQ(resolved_toml(again), resolved) << file;
  }
}

TEST(Scenario, ResolvedFileKeepsEveryKeyThatIsNotItsDefault) {
  const Scenario scenario = read(R"(
name = "all-different"
[channel]
nodes = 41
walls = "regularized"
side_walls = false
symmetry = "none"
half_width_y = 1.3
length = 9.7
reynolds = 0.1
wall_velocity = [-0.3, 0.1]
gravity = [1e-30, 0.1, -1e5]
start = "rest"
[fluid]
tau = 0.7000000000000001
collision = "trt"
magic = 0.25
equilibrium = "compressible"
frame = "walls"
storage = "double"
arithmetic = "double"
[membrane]
law = "neo-hookean"
area_ratio = 3.3
bending = 0
volume_modulus = 1234.5
mobility = 0.002
retraction = 0.3
integrator = "implicit"
theta = 0.6
substeps = 4
step_cuts = 3
edge = 0.9
frequency = 9
[rigid]
iterations = 7
memory = 0.85
retraction = 0.2
slip = 0.01
roughness = 0.003
interior = "solid"
edge = 1.1
frequency = 11
[run]
time_limit = 3.3
stop_distance = 4.4
until_decided = false
stop_at_contact = false
checkpoint_every = 2.5
patience = 3.5
[output]
every = 0.01
surfaces_every = 0
field_every = 1.5
[[body]]
name = "a_1"
laplace = 12.5
radius = 0.35
x = 0.1
y = -0.1
z = 2.2
shape = "biconcave"
rotation_axis = [0.1, 0.2, 0.3]
rotation_angle = -33.3
volume_modulus = 99.5
[[body]]
name = "b-2"
kind = "rigid"
density_ratio = 0.7
iterations = 2
)",
                                 "case.toml");
  EXPECT_EQ(scenario.fluid.tau, 0.7000000000000001);
  EXPECT_EQ(scenario.bodies[0].membrane.volume_modulus, 99.5);
  EXPECT_EQ(read(resolved_toml(scenario), "scenario.toml"), scenario);
  // Nothing was forgotten: only channel.symmetry has its default, the other going with walls alone.
  const auto lines = [](const Scenario& of) {
    std::vector<std::string> found;
    std::istringstream text(resolved_toml(of));
    std::string table;
    for (std::string line; std::getline(text, line);) {
      if (line.starts_with("[[")) break;
      if (line.starts_with('[')) table = line + ' ';
      if (line.find(" = ") != std::string::npos && line[0] != '#')
        found.push_back(table + line.substr(0, line.find(" #")));
    }
    return found;
  };
  const std::vector<std::string> here = lines(scenario);
  for (const std::string& line : lines(read("[[body]]\nlaplace = 1\n", "usual.toml"))) {
    if (line.starts_with("[channel] symmetry")) continue;
    EXPECT_EQ(std::ranges::count(here, line), 0) << line;
  }
}

TEST(Scenario, DocumentationNamesEveryKeyOfAResolvedFile) {
  const std::string documentation = describe_keys();
  const std::string resolved =
      resolved_toml(read("[[body]]\nlaplace = 1\n[[body]]\nkind = 'rigid'\nz = 3\n", "c"));
  int keys = 0;
  std::istringstream lines(resolved);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t equals = line.find(" = ");
    if (line.empty() || line[0] == '#' || equals == std::string::npos) continue;
    ++keys;
    const std::string key = line.substr(0, equals);
    EXPECT_NE(documentation.find("\n  " + key + " = "), std::string::npos) << key;
  }
  EXPECT_GT(keys, 50);
}

/// "case.toml:LINE:COLUMN: not valid TOML: ...", on one line.
bool is_syntax_error(const std::string& message) {
  int line = 0;
  int column = 0;
  int length = 0;
  std::sscanf(message.c_str(), "case.toml:%d:%d: not valid TOML: %n", &line, &column, &length);
  return length > 0 && line > 0 && column > 0 && message.find('\n') == std::string::npos;
}

struct Wrong {
  std::string text;
  std::string message;
};

TEST(Scenario, EveryMistakeGetsOneLineWithItsPlace) {
  const std::string capsule = "[[body]]\nname = \"a\"\nlaplace = 10\n";  // three lines
  const std::vector<Wrong> table = {
      // unknown keys and tables
      {"[channel]\nnodse = 36\n",
       "case.toml:2:1: channel.nodse: unknown key; did you mean \"nodes\"?"},
      {"[channel]\n  Nodes = 36\n",
       "case.toml:2:3: channel.Nodes: unknown key; did you mean \"nodes\"?"},
      {"[channel]\nhalf-width-y = 2\n",
       "case.toml:2:1: channel.half-width-y: unknown key; did you mean \"half_width_y\"?"},
      {"[channel]\ntau = 0.8\n", "case.toml:2:1: channel.tau: unknown key; it belongs in [fluid]"},
      {"[run]\nlaplace = 8\n", "case.toml:2:1: run.laplace: unknown key; it belongs in [[body]]"},
      {"tau = 0.8\n", "case.toml:1:1: tau: unknown key; it belongs in [fluid]"},
      {"[run]\nxyzzy = 1\n",
       "case.toml:2:1: run.xyzzy: unknown key; the keys are time_limit, stop_distance, "
       "until_decided, stop_at_contact, checkpoint_every, patience"},
      {"[chanel]\nnodes = 36\n", "case.toml:1:2: chanel: unknown table; did you mean \"channel\"?"},
      {"[quantum]\n",
       "case.toml:1:2: quantum: unknown table; the tables are body, channel, fluid, membrane, "
       "output, petsc, rigid, run"},
      {"[[bodies]]\n",
       "case.toml:1:3: bodies: unknown table; the tables are body, channel, fluid, membrane, "
       "output, petsc, rigid, run"},
      {"\"na\\nme\" = 1\n", "case.toml:1:1: \"na\\u000Ame\": unknown key; did you mean \"name\"?"},
      {capsule + "raduis = 0.3\n",
       "case.toml:4:1: body.a.raduis: unknown key; did you mean \"radius\"?"},
      // wrong types
      {"[channel]\nnodes = \"36\"\n",
       "case.toml:2:9: channel.nodes = \"36\": must be a whole number from 8 to 4096"},
      {"[channel]\nnodes = 36.0\n",
       "case.toml:2:9: channel.nodes = 36.0: must be a whole number from 8 to 4096"},
      {"[channel]\nnodes = [36]\n",
       "case.toml:2:9: channel.nodes = [36]: must be a whole number from 8 to 4096"},
      {"[channel]\nnodes = {n = 36}\n",
       "case.toml:2:9: channel.nodes: must be a whole number from 8 to 4096"},
      {"[channel]\nlength = true\n",
       "case.toml:2:10: channel.length = true: must be a number from 1 to 1000"},
      {"[channel]\nlength = 2021-02-22\n",
       "case.toml:2:10: channel.length = 2021-02-22: must be a number from 1 to 1000"},
      {"[channel]\nwalls = 1\n",
       "case.toml:2:9: channel.walls = 1: must be \"halfway\" or \"regularized\""},
      {"[channel]\nwalls = \"regularised\"\n",
       "case.toml:2:9: channel.walls = \"regularised\": must be \"halfway\" or \"regularized\"; "
       "did "
       "you mean \"regularized\"?"},
      {"[channel]\nside_walls = 1\n",
       "case.toml:2:14: channel.side_walls = 1: must be true or false"},
      {"[channel]\ngravity = [0, 1]\n",
       "case.toml:2:11: channel.gravity = [0, 1]: must be an array of 3 numbers"},
      {"[channel]\ngravity = [0, 1, \"2\"]\n",
       "case.toml:2:11: channel.gravity = [0, 1, \"2\"]: must be an array of 3 numbers"},
      {"[membrane]\nretraction = \"none\"\n",
       "case.toml:2:14: membrane.retraction = \"none\": must be \"felt\", or a number from 0 to 1"},
      {"[rigid]\nretraction = 2.5\n",
       "case.toml:2:14: rigid.retraction = 2.5: must be \"felt\", or a number from 0 to 2"},
      {"[fluid]\nstorage = \"double\"\narithmetic = \"single\"\n",
       "case.toml:3:14: fluid.arithmetic = \"single\": needs fluid.storage = "
       "\"single\"; with double storage take \"double\""},
      {"[membrane]\nlaw = \"hooke\"\n",
       "case.toml:2:7: membrane.law = \"hooke\": must be \"skalak\" or \"neo-hookean\""},
      {"name = 7\n",
       "case.toml:1:8: name = 7: must be a name of 1 to 64 letters, digits, '-' or '_'"},
      {"name = \"../x\"\n",
       "case.toml:1:8: name = \"../x\": must be a name of 1 to 64 letters, digits, '-' or '_'"},
      {"channel = 3\n", "case.toml:1:11: channel = 3: must be a table: write [channel]"},
      {"[body]\nlaplace = 3\n", "case.toml:1:1: body: must be an array of tables: write [[body]]"},
      {"body = [1]\n", "case.toml:1:9: body = 1: must be an array of tables: write [[body]]"},
      // out of bounds
      {"[channel]\nnodes = 7\n",
       "case.toml:2:9: channel.nodes = 7: must be a whole number from 8 to 4096"},
      {"[channel]\nnodes = 9223372036854775807\n",
       "case.toml:2:9: channel.nodes = 9223372036854775807: must be a whole number from 8 to 4096"},
      {"[fluid]\ntau = 0.5\n",
       "case.toml:2:7: fluid.tau = 0.5: must be a number above 0.5 and at most 1 (at 1/2 the "
       "viscosity vanishes; above 1 capsules drift to wrong places)"},
      {"[fluid]\ntau = 1.01\n",
       "case.toml:2:7: fluid.tau = 1.01: must be a number above 0.5 and at most 1 (at 1/2 the "
       "viscosity vanishes; above 1 capsules drift to wrong places)"},
      {"[fluid]\ntau = nan\n",
       "case.toml:2:7: fluid.tau = nan: must be a number above 0.5 and at most 1 (at 1/2 the "
       "viscosity vanishes; above 1 capsules drift to wrong places)"},
      {"[fluid]\nmagic = 0.26\n",
       "case.toml:2:9: fluid.magic = 0.26: must be a number above 0 and at most 0.25 (above 1/4 "
       "bodies drift to wrong places)"},
      {"[run]\ntime_limit = 0\n",
       "case.toml:2:14: run.time_limit = 0: must be a number above 0 and at most 100000"},
      {"[run]\nstop_distance = inf\n",
       "case.toml:2:17: run.stop_distance = inf: must be a number above 0"},
      {"[output]\nevery = -1\n",
       "case.toml:2:9: output.every = -1: must be a number above 0 and at most 100000"},
      {capsule + "radius = 0\n",
       "case.toml:4:10: body.a.radius = 0: must be a number above 0 and at most 20"},
      {capsule + "x = inf\n", "case.toml:4:5: body.a.x = inf: must be a number"},
      // what does not go together
      {"[run]\nstop_distance = 13\n",
       "case.toml:2:17: run.stop_distance = 13: must be at most channel.length = 12: further away "
       "is nearer to the periodic image"},
      {"[channel]\nwall_velocity = [1, -1]\nstart = \"developed\"\n",
       "case.toml:3:9: channel.start = \"developed\": must be \"rest\" where walls move and there "
       "are side walls, since no developed flow is known for it (or set channel.side_walls = "
       "false)"},
      {"[channel]\nwall_velocity = [1, -1]\n",
       "case.toml:1:1: channel.start: must be \"rest\" where walls move and there are side walls, "
       "since no developed flow is known for it (or set channel.side_walls = false)"},
      {"[channel]\nreynolds = 100\n",
       "case.toml:2:12: channel.reynolds = 100: makes the Mach number 0.8, at most 0.3 is sound: "
       "raise channel.nodes to 98 or lower fluid.tau"},
      {"[channel]\nwall_velocity = [0, -60]\nside_walls = false\n",
       "case.toml:2:17: channel.wall_velocity = [0, -60]: makes the Mach number 0.96, at most 0.3 "
       "is sound: raise channel.nodes to 117 or lower fluid.tau"},
      {"[channel]\nwall_velocity = [0, 1e12]\nside_walls = false\n",
       "case.toml:2:17: channel.wall_velocity = [0, 1000000000000.0]: makes the Mach number "
       "1.6e+10, at "
       "most 0.3 is sound: lower it"},
      {"[[body]]\nname = \"a\"\n",
       "case.toml:1:1: body.a.laplace: is missing: state the capsule's softness La = k_s a/(rho "
       "nu^2)"},
      {capsule + "density_ratio = 2\n",
       "case.toml:4:1: body.a.density_ratio: does not apply to a capsule: remove it"},
      {"[[body]]\nname = \"a\"\nkind = \"rigid\"\nlaplace = 10\n",
       "case.toml:4:1: body.a.laplace: does not apply to a rigid body: remove it"},
      {"[[body]]\nname = \"a\"\nkind = \"rigid\"\nmobility = 0\n",
       "case.toml:4:1: body.a.mobility: does not apply to a rigid body: remove it"},
      {"[[body]]\nname = \"a\"\nkind = \"rigid\"\nshape = \"biconcave\"\n",
       "case.toml:4:9: body.a.shape = \"biconcave\": rigid bodies are spheres: remove it"},
      {capsule + "rotation_axis = [0, 0, 0]\n",
       "case.toml:4:17: body.a.rotation_axis = [0, 0, 0]: must not be zero"},
      {capsule + "z = 6.5\n",
       "case.toml:4:5: body.a.z = 6.5: must be from -6 to 6: half of channel.length either way"},
      {capsule + "z = -3\n" + capsule,
       "case.toml:6:8: body.name = \"a\": two bodies are called \"a\": give each its own name"},
      {"[[body]]\nname = \"fluid\"\nlaplace = 10\n",
       "case.toml:2:8: body.name = \"fluid\": names the fluid in the output: call the "
       "body otherwise"},
      {"[[body]]\nname = \"channel\"\nlaplace = 10\n",
       "case.toml:2:8: body.name = \"channel\": names the channel in the output: call the "
       "body otherwise"},
      // bodies that do not fit
      {capsule + "x = 0.7\n",
       "case.toml:4:5: body.a.x = 0.7: body \"a\" reaches 0.1 W into the wall at x = 1: move it or "
       "make it smaller"},
      {capsule + "y = -0.7\n",
       "case.toml:4:5: body.a.y = -0.7: body \"a\" reaches 0.1 W into the wall at y = -1: move it "
       "or make it smaller"},
      {"[channel]\nnodes = 20\n" + capsule + "x = 0.5\n",
       "case.toml:2:9: channel.nodes = 20: too few nodes across the gap between body \"a\" and the "
       "wall at x = 1: 1.00 lattice spacings, at least 2 needed: raise channel.nodes to 40 or move "
       "the body"},
      {capsule + "z = 1.0\n[[body]]\nlaplace = 10\nz = 1.7\n",
       "case.toml:5:1: body.body2: overlaps body \"a\": move one of them"},
      {"[channel]\nnodes = 24\n" + capsule + "[[body]]\nlaplace = 10\nz = 0.85\n",
       "case.toml:2:9: channel.nodes = 24: too few nodes across the gap between body \"a\" and "
       "body \"body2\": 0.60 lattice spacings, at least 1 needed: raise channel.nodes to 40 or "
       "move the body"},
      {"[channel]\nlength = 1\n[[body]]\nname = \"a\"\nlaplace = 10\nradius = 0.6\n",
       "case.toml:6:10: body.a.radius = 0.6: body \"a\" overlaps its own periodic image: make the "
       "channel longer or the body smaller"},
      {"[channel]\nnodes = 24\nlength = 1\n" + capsule,
       "case.toml:2:9: channel.nodes = 24: too few nodes across the gap between body \"a\" and its "
       "own "
       "periodic image: 2.40 lattice spacings, at least 5 needed: raise channel.nodes to 50 or "
       "move "
       "the body"},
      {"[channel]\nnodes = 16\n" + capsule + "radius = 0.2\n",
       "case.toml:2:9: channel.nodes = 16: too few nodes: the radius of body \"a\" is 1.6 lattice "
       "spacings, at least 2 are needed: raise channel.nodes to 20 or make it larger"},
      // what is not symmetric about y = 0
      {"[channel]\nsymmetry = \"x\"\n",
       "case.toml:2:12: channel.symmetry = \"x\": must be \"none\" or \"y\"; did you mean \"y\"?"},
      {"[channel]\nsymmetry = \"y\"\nside_walls = false\n",
       "case.toml:2:12: channel.symmetry = \"y\": must be \"none\" where channel.side_walls = "
       "false: the plane of symmetry needs a wall to face"},
      {"[channel]\nsymmetry = \"y\"\ngravity = [1, 2, 3]\n",
       "case.toml:3:11: channel.gravity = [1, 2, 3]: must be 0 along y where "
       "channel.symmetry = \"y\": set that to \"none\""},
      {"[channel]\nnodes = 17\nwalls = \"regularized\"\nhalf_width_y = 0.3\nsymmetry = \"y\"\n",
       "case.toml:5:12: channel.symmetry = \"y\": leaves 3 nodes along y, at least 4 are needed: "
       "use "
       "more channel.nodes, or set it to \"none\""},
      {"[channel]\nsymmetry = \"y\"\n" + capsule + "y = 0.1\n",
       "case.toml:6:5: body.a.y = 0.1: must be 0 where channel.symmetry = \"y\": put the body on "
       "the plane of symmetry, or set channel.symmetry = \"none\""},
      {"[channel]\nsymmetry = \"y\"\n" + capsule +
           "rotation_axis = [1, 0, 0]\nrotation_angle = 30\n",
       "case.toml:6:17: body.a.rotation_axis = [1, 0, 0]: turns the mesh of body \"a\" so that it "
       "is "
       "not its own mirror image about y = 0 to 1e-09 radii: use [0, 1, 0], or set "
       "channel.symmetry = \"none\""},
      {"[petsc]\n-membrane_ksp_type = \"cg\"\n",
       "case.toml:2:1: petsc.-membrane_ksp_type: must be the name of a PETSc option without its "
       "dash, such as membrane_ksp_rtol"},
      {"[petsc]\nmembrane_ksp_rtol = [1]\n",
       "case.toml:2:21: petsc.membrane_ksp_rtol = [1]: must be a number, a string, or true or "
       "false"},
      {"petsc = 3\n", "case.toml:1:9: petsc = 3: must be a table: write [petsc]"},
      {capsule + "theta = 0.2\n",
       "case.toml:4:9: body.a.theta = 0.2: must be a number from 0.5 to 1"},
      // no TOML at all
      {"[channel\nnodes = 3\n", ""},
      {"[channel]\nnodes = \n", ""},
      {"[channel]\nnodes = 36\nnodes = 48\n", ""},
      {"[channel]\n[channel]\n", ""},
      {"\xff\xfe", ""},
  };
  for (const Wrong& wrong : table) {
    const std::string message = refusal(wrong.text);
    if (wrong.message.empty()) {
      EXPECT_TRUE(is_syntax_error(message)) << wrong.text << "gave: " << message;
    } else {
      EXPECT_EQ(message, wrong.message) << wrong.text;
    }
  }
}

// What is found for a body is a value that the key takes, whatever the lattice.
TEST(Scenario, ARetractionThatWasFoundCanBeReadAgain) {
  for (const char* kind : {"kind = 'rigid'", "laplace = 0", "laplace = 10\nshape = 'biconcave'"}) {
    for (const char* radius : {"0.25", "0.35", "0.45"}) {
      for (const char* tau : {"0.501", "0.6", "1.0"}) {
        const Scenario found = read(std::string("[channel]\nnodes = 17\n[fluid]\ntau = ") + tau +
                                        "\n[[body]]\nradius = " + radius + "\n" + kind + "\n",
                                    "case.toml");
        EXPECT_EQ(read(resolved_toml(found), "scenario.toml"), found) << kind << radius << tau;
      }
    }
  }
}

// Fluid inside unless that is said to be otherwise, or the body is too light for it: at a = 18 dx
// below 1 - 7.5/18 with markers on the surface, and 0.606 where they lie by default.
TEST(Scenario, ALightBodyIsSolidUnlessToldOtherwiseAndThenRefused) {
  const std::string channel = "[channel]\nnodes = 80\n";
  const auto body = [](const std::string& ratio, const std::string& radius = "0.45") {
    return "[[body]]\nname = \"a\"\nkind = \"rigid\"\nradius = " + radius +
           "\ndensity_ratio = " + ratio + "\n";
  };
  const auto interior = [](const std::string& text) {
    return read(text, "case.toml").bodies.at(0).rigid.interior;
  };
  using enum suspension::Interior;
  EXPECT_EQ(interior(channel + body("0.57")), solid);
  EXPECT_EQ(interior(channel + body("0.62")), fluid);
  EXPECT_EQ(interior("[channel]\nnodes = 30\n" + body("0.5")), fluid);
  // In half a channel nothing answers motion off its plane: (M_f - M)/A is 2.2 here.
  const std::string whole = "[channel]\nnodes = 30\n";
  const std::string half = whole + "symmetry = \"y\"\n";
  EXPECT_EQ(interior(whole + body("0.5", "0.84")), fluid);
  EXPECT_EQ(interior(half + body("0.5", "0.84")), solid);
  EXPECT_EQ(interior(half + body("0.58", "0.84")), fluid);
  // A small solid has its shells too, and what is too light for them is refused by its bound.
  EXPECT_EQ(interior("[channel]\nnodes = 16\n" + body("0.7", "0.25") + "interior = \"solid\"\n"),
            solid);
  EXPECT_NE(refusal("[channel]\nnodes = 16\n" + body("0.5", "0.25") + "interior = \"solid\"\n")
                .find("a.density_ratio = 0.5: must be at least 0.637 for a solid of this size"),
            std::string::npos);
  // Markers inside of the surface have less area.
  EXPECT_EQ(interior(channel + body("0.6") + "retraction = 0\n"), fluid);
  EXPECT_EQ(interior(channel + body("0.62") + "retraction = 1\n"), solid);
  const std::string common = "[rigid]\ninterior = ";
  EXPECT_EQ(interior(channel + common + "\"solid\"\n" + body("2")), solid);
  const Scenario light = read(channel + body("0.57"), "case.toml");
  EXPECT_EQ(read(resolved_toml(light), "scenario.toml"), light);

  EXPECT_EQ(refusal(channel + body("0.57")), "");
  EXPECT_NE(refusal(channel + common + "\"fluid\"\n" + body("0.57")), "");
  EXPECT_EQ(
      refusal(channel + body("0.57") + "interior = \"fluid\"\n"),
      "case.toml:7:17: body.a.density_ratio = 0.57: must be at least 0.606 for a body of this "
      "size with fluid inside: raise it, or set interior = \"solid\"");
}

// Meshes of any frequency, turned about y or by right angles, are their own mirror images.
TEST(Scenario, BodiesOnAPlaneOfSymmetryAreTakenIfTheirMeshesAreSymmetric) {
  const std::string text =
      "[channel]\nsymmetry = \"y\"\n[[body]]\nlaplace = 10\nradius = 0.3\nx = 0.1\n";
  for (const std::string shape : {"sphere", "biconcave"}) {
    for (const std::string frequency : {"1", "2", "3", "6", "9", "20", "32"}) {
      const std::string body = fmt::format(
          "{}shape = \"{}\"\nfrequency = {}\nrotation_angle = ", text, shape, frequency);
      EXPECT_EQ(refusal(body + "0\n"), "");
      EXPECT_EQ(refusal(body + "33.3\n"), "");
      EXPECT_EQ(refusal(body + "90\nrotation_axis = [1, 0, 0]\n"), "");
      EXPECT_NE(refusal(body + "33.3\nrotation_axis = [1, 1, 0]\n"), "");
    }
  }
  EXPECT_EQ(refusal("[channel]\nsymmetry = \"y\"\n[[body]]\nkind = \"rigid\"\n"), "");
}

TEST(Scenario, PetscOptionsAreKeptAsPetscReadsThem) {
  const Scenario scenario = read(
      "[petsc]\nmembrane_ksp_rtol = 1e-4\nmembrane_pc_type = \"icc\"\nlog_view = true\n"
      "membrane_snes_monitor = false\nmembrane_snes_max_it = 7\n",
      "case.toml", {set("petsc.membrane_tangent_lag", "3")});
  const std::vector<PetscOption> expected = {{"log_view", ""},
                                             {"membrane_ksp_rtol", "0.0001"},
                                             {"membrane_pc_type", "icc"},
                                             {"membrane_snes_max_it", "7"},
                                             {"membrane_snes_monitor", "false"},
                                             {"membrane_tangent_lag", "3"}};
  EXPECT_EQ(scenario.petsc, expected);
  EXPECT_EQ(read(resolved_toml(scenario), "case.toml"), scenario);
}

TEST(Scenario, SyntaxErrorsNameTheLine) {
  EXPECT_EQ(refusal("[channel]\nnodes = 36\nnodes = 48\n").substr(0, 12), "case.toml:3:");
  EXPECT_EQ(refusal("[channel]\nnodes = 36\n\nwalls = \"half\n").substr(0, 12), "case.toml:4:");
}

TEST(Scenario, MistakesInOverridesAreCalledByTheirOption) {
  struct Case {
    Override override;
    std::string message;
  };
  const std::vector<Case> table = {
      {set("channel.nodes", "abc"),
       "--set channel.nodes=abc: must be a whole number from 8 to 4096"},
      {set("channel.nodes", ""), "--set channel.nodes=: must be a whole number from 8 to 4096"},
      {set("output.every", ".05"),
       "--set output.every=.05: must be a number above 0 and at most 100000; TOML wants a digit on "
       "both sides of the point, as in 0.5"},
      {set("fluid.tau", "1."),
       "--set fluid.tau=1.: must be a number above 0.5 and at most 1 (at 1/2 the viscosity "
       "vanishes; above 1 capsules drift to wrong places); TOML wants a digit on both sides of the "
       "point, as in 0.5"},
      {set("channel.gravity", "[0, 0, -.5]"),
       "--set channel.gravity=[0, 0, -.5]: must be an array of 3 numbers; TOML wants a digit on "
       "both sides of the point, as in 0.5"},
      {set("channel.nodse", "48"), "--set channel.nodse=48: unknown key; did you mean \"nodes\"?"},
      {set("chanel.nodes", "48"),
       "--set chanel.nodes=48: unknown table; did you mean \"channel\"?"},
      {set("body.lga.x", "0"),
       "--set body.lga.x=0: there is no body \"lga\"; the bodies are: lead, lag"},
      {set("body.lag", "0"),
       "--set body.lag=0: the key must be TABLE.KEY, or body.NAME.KEY for a body of that name"},
      {set("a.b.c", "0"),
       "--set a.b.c=0: the key must be TABLE.KEY, or body.NAME.KEY for a body of that name"},
      {set("body.lag.x", "0.8"),
       "--set body.lag.x=0.8: body \"lag\" reaches 0.2 W into the wall at x = 1: move it or make "
       "it smaller"},
      {{"fluid.tau", "2", "--tau 2"},
       "--tau 2: must be a number above 0.5 and at most 1 (at 1/2 the viscosity vanishes; above 1 "
       "capsules drift to wrong places)"},
      {set("channel.nodes", "48\nwalls = 3"),
       "--set channel.nodes=48\nwalls = 3: must be a whole number from 8 to 4096"},
  };
  for (const Case& wrong : table)
    EXPECT_EQ(refusal(pair_text, {wrong.override}), wrong.message) << wrong.override.origin;
}

TEST(Scenario, FilesThatCannotBeReadAreRefused) {
  const auto refused = [](const std::filesystem::path& file) -> std::string {
    try {
      load(file);
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(refused("no/such.toml"), "no/such.toml: cannot be read: No such file or directory");
  EXPECT_EQ(refused("/"), "/: is a directory, not a scenario file");
}

// Whatever a slip of the keyboard makes of a valid file, it is understood or refused in one line.
TEST(Scenario, AnyMutilatedFileIsUnderstoodOrRefusedInOneLine) {
  const std::string valid = contents(scenario_dir / "quickstart.toml");
  ASSERT_GT(valid.size(), 1000U);
  ASSERT_EQ(refusal(valid), "");
  const auto one_line = [](const std::string& message) {
    if (message.rfind("case.toml:", 0) != 0 || message.size() > 700) return false;
    for (const char c : message)
      if (static_cast<unsigned char>(c) < 32 || c == 127) return false;
    return true;
  };
  using namespace std::string_literals;
  const std::string strange = "\0\"'[]{}=#.,-+x9e\n\r\t\\\x7f\x80\xff"s;
  int understood = 0;
  int refused = 0;
  const auto examine = [&](const std::string& text, std::size_t at) {
    const std::string message = refusal(text);
    (message.empty() ? understood : refused) += 1;
    ASSERT_TRUE(message.empty() || one_line(message)) << "byte " << at << ": " << message;
  };
  for (std::size_t i = 0; i < valid.size(); ++i) {
    std::string text = valid;
    text.erase(i, 1);
    examine(text, i);
    examine(valid.substr(0, i), i);
    // Three of them at each byte, and over eight bytes all.
    for (std::size_t j = 0; j < 3; ++j) {
      const char c = strange[(3 * i + j) % strange.size()];
      text = valid;
      text[i] = c;
      examine(text, i);
      text = valid;
      text.insert(i, 1, c);
      examine(text, i);
    }
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(understood, 1000);
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace ductile::drivers
