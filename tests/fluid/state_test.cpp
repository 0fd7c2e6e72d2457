// A fluid whose state was loaded goes on as the one whose state was saved, to the last bit.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ductile/fluid/d3q19.hpp"
#include "ductile/fluid/fluid.hpp"
#include "ductile/fluid/points.hpp"
#include "fluid/precisions.hpp"

namespace {

using namespace ductile::fluid;

using State = std::map<std::string, std::vector<double>, std::less<>>;

State state_of(Fluid& fluid) {
  State state;
  fluid.save([&](std::string_view name, std::span<const double> numbers) {
    const bool is_new = state.emplace(name, std::vector(numbers.begin(), numbers.end())).second;
    EXPECT_TRUE(is_new) << name;
  });
  return state;
}

void copy_to(const std::vector<double>& from, std::span<double> to) {
  if (from.size() != to.size()) throw std::runtime_error("wrong size");
  std::copy(from.begin(), from.end(), to.begin());
}

StateReader reader_of(const State& state) {
  return [&](std::string_view name, std::span<double> to) {
    const auto found = state.find(name);
    if (found == state.end()) throw std::runtime_error("no " + std::string(name));
    copy_to(found->second, to);
  };
}

// The planes of `slab` of numbers at all nodes.
std::vector<double> sliced(const std::vector<double>& whole, int nz, Range slab) {
  std::vector<double> own;
  for (std::size_t column = 0; column < whole.size(); column += static_cast<std::size_t>(nz)) {
    const auto first = whole.begin() + static_cast<std::ptrdiff_t>(column);
    own.insert(own.end(), first + slab.begin, first + slab.end);
  }
  return own;
}
State sliced(const State& whole, int nz, Range slab) {
  State own;
  for (const auto& [name, numbers] : whole) {
    own[name] = numbers.size() <= 3 ? numbers : sliced(numbers, nz, slab);
  }
  return own;
}

std::vector<double> fields_of(Fluid& fluid) {
  const auto& n = fluid.options().nodes;
  const auto count = static_cast<std::size_t>(n[0] * n[1] * fluid.slab().size());
  std::vector<double> all(4 * count);
  fluid.fields(std::span(all).first(count), std::span(all).subspan(count));
  return all;
}

void initialise(Fluid& fluid, double phase) {
  fluid.initialise([&](int i, int j, int k) {
    NodeState s;
    s.density = 1 + 0.01 * std::sin(1.1 * i + 0.7 * j - 1.9 * k + phase);
    s.velocity = {0.02 * std::sin(0.9 * j + k), 0.01 * std::cos(i - 0.4 * k), 0.03 * std::sin(i)};
    // Symmetric where a mirror plane lies on the node.
    if (fluid.options().mirror == Mirror::on_node && j == 0) s.velocity.y() = 0;
    return s;
  });
}

// Points in two boxes that push at the fluid a little.
class Driven {
 public:
  Driven(MPI_Comm comm, const Options& o, double phase) : fluid(comm, o) {
    initialise(fluid, phase);
    const std::array<Box, 2> boxes = {Box{{{2, 7}, {2, 7}, {1, 6}}},
                                      Box{{{2, 7}, {2, 7}, {7, 12}}}};
    fluid.place_boxes(boxes);
    for (int box : {0, 1}) {
      points_.emplace_back(fluid, box);
      points_.back().locate(std::vector<double>{4.2, 4.1, box == 0 ? 3.3 : 9.2});
    }
  }
  void steps(int count) {
    for (int n = 0; n < count; ++n) {
      const double f = 1e-4 * std::sin(static_cast<double>(fluid.time()));
      if (fluid.options().boundary[2] == Boundary::periodic) fluid.accelerate(0.1 * f);
      points_[0].add_force(std::vector<double>{f, -f, 2e-4});
      points_[1].add_force(std::vector<double>{2e-4, f, -f});
      fluid.step();
    }
  }
  Fluid fluid;

 private:
  std::vector<Points> points_;
};

struct Case {
  const char* name;
  std::array<Boundary, 3> boundary;
  Mirror mirror = Mirror::none;
};

Options options_of(const Case& c, Collision collision, const ductile::test::Precisions& precision) {
  Options o;
  o.nodes = {9, 8, 13};
  o.boundary = c.boundary;
  o.mirror = c.mirror;
  o.tau = 0.8;
  o.collision = collision;
  precision.choose(o);
  const bool mirrored = c.mirror != Mirror::none;
  o.force = {1e-4, mirrored ? 0 : -2e-4, 3e-4};
  if (c.boundary[0] != Boundary::periodic) {
    o.wall_velocity[0] = {Eigen::Vector3d(0, mirrored ? 0 : 0.01, 0.02),
                          Eigen::Vector3d(0, 0, -0.03)};
  }
  if (c.boundary[1] != Boundary::periodic) {
    o.wall_velocity[1][1] = {0.01, 0, 0.02};
    if (!mirrored) o.wall_velocity[1][0] = {-0.01, 0, 0.01};
  }
  if (c.boundary[2] != Boundary::periodic) {
    o.wall_velocity[2] = {Eigen::Vector3d(0.02, 0, 0),
                          Eigen::Vector3d(0.01, mirrored ? 0 : -0.01, 0)};
  }
  return o;
}

class SavedState
    : public testing::TestWithParam<std::tuple<Case, Collision, ductile::test::Precisions>> {
 protected:
  [[nodiscard]] static Options options() {
    const auto& [c, collision, precision] = GetParam();
    return options_of(c, collision, precision);
  }
};

TEST_P(SavedState, GoesOnToTheLastBit) {
  const Options o = options();
  for (const int before : {0, 3, 4}) {
    Driven saved(MPI_COMM_WORLD, o, 0);
    saved.steps(before);
    const State state = state_of(saved.fluid);
    EXPECT_EQ(state_of(saved.fluid), state);  // saving changes nothing
    Driven loaded(MPI_COMM_WORLD, o, 1);
    loaded.steps(3 -
                 before % 2);  // in the other state of the in-place streaming, messages under way
    loaded.fluid.load(reader_of(state));
    EXPECT_EQ(loaded.fluid.time(), before);
    EXPECT_EQ(state_of(loaded.fluid), state);
    EXPECT_EQ(fields_of(loaded.fluid), fields_of(saved.fluid));
    for (const int more : {1, 1, 3}) {
      saved.steps(more);
      loaded.steps(more);
      ASSERT_EQ(fields_of(loaded.fluid), fields_of(saved.fluid)) << before << ' ' << more;
      ASSERT_EQ(state_of(loaded.fluid), state_of(saved.fluid)) << before << ' ' << more;
    }
  }
}

// Each rank also computes the whole on its own: the whole's state, cut into slices, is that of the
// slabs, and goes on in them.
TEST_P(SavedState, IsTheSameOnAnyNumberOfRanks) {
  const Options o = options();
  const int nz = o.nodes[2];
  for (const int before : {3, 4}) {
    Driven whole(MPI_COMM_SELF, o, 0);
    Driven cut(MPI_COMM_WORLD, o, 0);
    Driven loaded(MPI_COMM_WORLD, o, 1);
    whole.steps(before);
    cut.steps(before);
    const Range slab = cut.fluid.slab();
    const State slices = sliced(state_of(whole.fluid), nz, slab);
    EXPECT_EQ(state_of(cut.fluid), slices);
    loaded.steps(before + 1);
    loaded.fluid.load(reader_of(slices));
    for (const int more : {1, 1, 3}) {
      whole.steps(more);
      loaded.steps(more);
      ASSERT_EQ(fields_of(loaded.fluid), sliced(fields_of(whole.fluid), nz, slab))
          << before << ' ' << more;
      ASSERT_EQ(state_of(loaded.fluid), sliced(state_of(whole.fluid), nz, slab))
          << before << ' ' << more;
    }
  }
}

constexpr auto periodic = Boundary::periodic;
constexpr auto halfway = Boundary::halfway;
constexpr auto regularized = Boundary::regularized;

INSTANTIATE_TEST_SUITE_P(
    Walls, SavedState,
    testing::Combine(
        testing::Values(
            Case{"periodic", {periodic, periodic, periodic}},
            Case{"channel", {halfway, halfway, periodic}},
            Case{"closed", {halfway, halfway, halfway}},
            Case{"plates", {periodic, halfway, halfway}},
            Case{"on_nodes", {regularized, regularized, periodic}},
            Case{"on_nodes_closed", {regularized, regularized, halfway}},
            Case{"mixed", {halfway, regularized, halfway}},
            Case{"mirror_between", {halfway, halfway, halfway}, Mirror::between_nodes},
            Case{"mirror_between_on_nodes",
                 {regularized, regularized, periodic},
                 Mirror::between_nodes},
            Case{"mirror_on_node", {periodic, halfway, halfway}, Mirror::on_node},
            Case{"mirror_on_node_on_nodes", {regularized, regularized, periodic}, Mirror::on_node}),
        testing::Values(Collision::bgk, Collision::trt),
        testing::ValuesIn(ductile::test::precisions)),
    [](const auto& test) {
      return std::string(std::get<0>(test.param).name) +
             (std::get<1>(test.param) == Collision::bgk ? "_bgk_" : "_trt_") +
             std::get<2>(test.param).name;
    });

// Mass and momentum by the definition of the moments: the populations have the documented order.
TEST(State, IsThePopulationsLessTheirRestWeights) {
  Options o;
  o.nodes = {6, 5, 13};
  o.lattice_velocity = 0.25;
  Fluid fluid(MPI_COMM_WORLD, o);
  initialise(fluid, 0);
  for (int n = 0; n < 3; ++n) fluid.step();
  const State state = state_of(fluid);
  EXPECT_EQ(state.at("time"), std::vector<double>{3});
  EXPECT_EQ(state.at("lattice"), (std::vector<double>{3 * 0.25, 0.25, 0}));
  EXPECT_EQ(state.size(), 21U);
  const std::vector<double> fields = fields_of(fluid);
  const std::size_t count = fields.size() / 4;
  for (std::size_t n = 0; n < count; ++n) {
    double density = 1;
    Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
    for (int i = 0; i < d3q19::Q; ++i) {
      const double f = state.at((i < 10 ? "f0" : "f") + std::to_string(i))[n];
      const auto c = d3q19::c(i);
      density += f;
      momentum += f * Eigen::Vector3d(c[0], c[1], c[2]);
    }
    EXPECT_NEAR(fields[n], density, 1e-15);
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(fields[(a + 1) * count + n], momentum[static_cast<Eigen::Index>(a)] / density,
                  1e-16);
    }
  }
}

TEST(State, ThatIsNotFiniteAnywhereIsFoundWithinEightSteps) {
  for (const auto walls : {Boundary::halfway, Boundary::regularized, Boundary::periodic}) {
    Options options;
    options.nodes = {19, 13, 10};
    options.boundary = {walls, walls, Boundary::periodic};
    Fluid fluid(MPI_COMM_SELF, options);
    const State good = state_of(fluid);
    EXPECT_TRUE(fluid.finite());
    for (const auto& [i, j] : {std::pair(0, 0), {18, 12}, {0, 12}, {9, 7}, {18, 0}, {5, 3}}) {
      State bad = good;
      const int row = i * 13 + j;
      bad["f00"][10 * static_cast<std::size_t>(row) + 6] = std::nan("");
      fluid.load(reader_of(bad));
      for (int n = 0; n < 8; ++n) fluid.step();
      EXPECT_FALSE(fluid.finite()) << i << " " << j;
      EXPECT_FALSE(fluid.totals().finite());
    }
    fluid.load(reader_of(good));
    for (int n = 0; n < 8; ++n) fluid.step();
    EXPECT_TRUE(fluid.finite());
  }
}

TEST(State, AReadersExceptionPassesThroughAndAnotherLoadMakesGood) {
  Options o;
  o.nodes = {6, 5, 13};
  Fluid fluid(MPI_COMM_WORLD, o);
  initialise(fluid, 0);
  fluid.step();
  const State state = state_of(fluid);
  State broken = state;
  broken.erase("f11");
  broken.at("f00").front() = 7;
  EXPECT_THROW(fluid.load(reader_of(broken)), std::runtime_error);
  fluid.load(reader_of(state));
  EXPECT_EQ(state_of(fluid), state);
}

}  // namespace
