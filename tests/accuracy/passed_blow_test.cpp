// Blows that bodies in a row pass on, which fly or topple by several of their thicknesses a step: no time is lost where
// one meets the next.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test::passed_blow_test {
namespace {

constexpr double thickness = 0.0075;  // m

struct Case {
  ContactSolver solver;
  int substeps;
};

std::string name_of(const ::testing::TestParamInfo<Case>& info) {
  const char* const solver = info.param.solver == ContactSolver::Auto     ? "Auto"
                             : info.param.solver == ContactSolver::Direct ? "Direct"
                                                                          : "Iterative";
  return solver + std::to_string(info.param.substeps);
}

class PassedBlow : public ::testing::TestWithParam<Case> {
 protected:
  static Settings settings() { return {.substeps = GetParam().substeps, .contact_solver = GetParam().solver}; }
};

// The centre of mass of a row keeps its speed, however often one hits the next: what is stopped for the rest of a step
// falls behind.
TEST_P(PassedBlow, ARowLosesNoTime) {
  constexpr int count = 5;
  constexpr double gap = 0.03, speed = 1;  // 1.8 steps from one to the next
  for (const Shape& shape : {Shape(Box{{thickness / 2, 0.0125, 0.025}}), Shape(Sphere{thickness / 2})}) {
    for (const double restitution : {0.0, 1.0}) {
      World world({.gravity = Vector3::Zero(), .settings = settings()});
      std::vector<BodyId> ids;
      for (int i = 0; i < count; ++i) {
        ids.push_back(world.add_body({.shape = shape,
                                      .position = {i * (thickness + gap), 0, 0},
                                      .mass = 1,
                                      .material = {.friction = 0, .restitution = restitution}}));
      }
      world.set_velocity(ids[0], {speed, 0, 0}, Vector3::Zero());
      const auto centre = [&] {
        double sum = 0;
        for (const BodyId id : ids) sum += world.pose(id).position.x();
        return sum / count;
      };
      const double start = centre();
      // The last is hit after as many gaps as there are bodies ahead of it; the k-th goes at speed / k where it sticks.
      const double gaps = restitution > 0 ? count - 1 : count * (count - 1) / 2;
      const int steps = static_cast<int>(std::ceil(gaps * gap / speed / dt)) + 1;
      run(world, steps);
      const double way = steps * dt * speed / count;
      EXPECT_NEAR(centre() - start, way, 2e-3 * way) << restitution;
      EXPECT_NEAR(world.velocity(ids.back()).x(), restitution > 0 ? speed : speed / count, 0.02 * speed) << restitution;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, PassedBlow,
                         ::testing::Values(Case{ContactSolver::Auto, 4}, Case{ContactSolver::Direct, 16},
                                           Case{ContactSolver::Iterative, 4}, Case{ContactSolver::Direct, 4}),
                         name_of);

// Speed of a wave of toppling dominoes by sqrt(g h), between the tenth and the thirtieth.
double domino_speed(double gap, double friction, const Settings& settings, double step) {
  constexpr int count = 36;
  constexpr std::size_t from = 10, to = 30;
  constexpr double h = 0.05, push = 0.3;  // m, m/s
  World world({.settings = settings});
  world.add_body(ground(0.7));
  const double pitch = gap * h + thickness;
  std::vector<BodyId> ids;
  for (int i = 0; i < count; ++i) {
    ids.push_back(world.add_body({.shape = Box{{thickness / 2, h / 4, h / 2}},
                                  .position = {i * pitch, 0, h / 2},
                                  .material = {.friction = friction}}));
  }
  world.set_velocity(ids[0], {push, 0, 0}, {0, push / (h / 2), 0});
  // When each leans by a tenth, between two steps.
  std::vector<double> toppled(count, 0), leans(count, 0);
  for (double time = step; time < 3 && toppled[to] == 0; time += step) {
    world.step(step);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (toppled[i] > 0) continue;
      const double before = leans[i];
      leans[i] = (world.pose(ids[i]).orientation * Vector3::UnitZ()).x();
      if (leans[i] > 0.1) toppled[i] = time - step * (leans[i] - 0.1) / (leans[i] - before);
    }
  }
  return (to - from) * pitch / (toppled[to] - toppled[from]) / std::sqrt(g * h);
}

// Their tops get by two thicknesses a step, and the wave by a domino in 1.7 to 3.3 steps.
TEST(Dominoes, ToppleAtTheirSpeedInStepsOfASixtieth) {
  // By steps of 1/960 s.
  const struct {
    double gap, friction, right;
  } rows[] = {{0.2, 0.7, 0.872}, {0.3, 0.7, 0.870}, {0.5, 0.7, 0.834}, {0.2, 0.2, 1.489}, {0.3, 0.2, 1.444}};
  for (const auto& row : rows) {
    const double speed = domino_speed(row.gap, row.friction, {}, dt);
    EXPECT_NEAR(speed, row.right, 0.1 * row.right) << row.gap << ' ' << row.friction;
  }
}

}  // namespace
}  // namespace atl::test::passed_blow_test
