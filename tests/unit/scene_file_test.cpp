// Worlds made from scene files. Their refusals are in scene_file_errors_test.cpp.

#include <atoll/scene.h>
#include <gtest/gtest.h>

#include "support/expect_error.h"

namespace atl {
namespace {

Scene parse(const std::string& members) {
  return parse_scene(R"({"format": "atoll-scene", "version": 1, )" + members + "}", "folder/test.json");
}

// A scene of one body.
BodyDef only_body(const std::string& members) { return parse(R"("bodies": [{)" + members + "}]").bodies.at(0).def; }

constexpr const char* the_ball = R"("shape": {"type": "sphere", "radius": 0.5})";

TEST(SceneFile, DefaultsAreThoseOfTheApi) {
  const Scene scene = parse(R"("bodies": [{"shape": {"type": "sphere", "radius": 2}}])");
  const Scene none;
  EXPECT_EQ(scene.name, "test");
  EXPECT_EQ(scene.gravity, none.gravity);
  EXPECT_EQ(scene.dt, none.dt);
  EXPECT_EQ(scene.steps, none.steps);
  EXPECT_FALSE(scene.starts_at_rest);
  EXPECT_EQ(scene.settings.substeps, none.settings.substeps);
  EXPECT_EQ(scene.settings.tolerance, none.settings.tolerance);
  EXPECT_EQ(scene.settings.stabilisation, none.settings.stabilisation);
  EXPECT_EQ(scene.settings.correction, none.settings.correction);
  EXPECT_EQ(scene.settings.slop, none.settings.slop);
  EXPECT_EQ(scene.settings.joint_solver, none.settings.joint_solver);
  EXPECT_EQ(scene.settings.joint_hertz, none.settings.joint_hertz);
  EXPECT_EQ(scene.settings.joint_damping_ratio, none.settings.joint_damping_ratio);

  ASSERT_EQ(scene.bodies.size(), 1u);
  const BodyDef& def = scene.bodies[0].def;
  const BodyDef defaults;
  EXPECT_EQ(scene.bodies[0].name, "");
  EXPECT_EQ(def.type, BodyType::Dynamic);
  EXPECT_EQ(std::get<Sphere>(def.shape).radius, 2);
  EXPECT_EQ(def.position, Vector3::Zero());
  EXPECT_EQ(def.orientation.coeffs(), Quaternion::Identity().coeffs());
  EXPECT_EQ(def.density, defaults.density);
  EXPECT_FALSE(def.mass);
  EXPECT_FALSE(def.inertia);
  EXPECT_EQ(def.material.friction, defaults.material.friction);
  EXPECT_EQ(def.gravity_scale, 1);
}

TEST(SceneFile, ReadsTheWorld) {
  const Scene scene = parse(R"("name": "n", "description": "d", "gravity": [1, -2.5, 3e-1], "dt": 0.01, "steps": 7,
                               "starts_at_rest": true, "bodies": [{"name": "b", "shape": {"type": "half_space"},
                               "type": "static"}])");
  EXPECT_EQ(scene.name, "n");
  EXPECT_EQ(scene.gravity, Vector3(1, -2.5, 0.3));
  EXPECT_EQ(scene.dt, 0.01);
  EXPECT_EQ(scene.steps, 7);
  EXPECT_TRUE(scene.starts_at_rest);
  EXPECT_EQ(scene.bodies[0].name, "b");
}

TEST(SceneFile, ReadsEverySetting) {
  const Settings s = parse(R"("settings": {"substeps": 8, "iterations": 2, "relax_iterations": 0, "tolerance": 0.001,
                              "friction": "pyramid", "warm_starting": false, "stabilisation": "baumgarte",
                              "correction": 0.3, "slop": 0.25, "contact_hertz": 60, "contact_damping_ratio": 1,
                              "contact_push_speed": 2, "restitution_threshold": 0.5, "joint_solver": "direct", "joint_hertz": 20,
                              "joint_damping_ratio": 3, "sleeping": true, "sleep_speed": 0.1,
                              "time_to_sleep": 1}, "bodies": [{)" +
                           std::string(the_ball) + "}]")
                         .settings;
  EXPECT_EQ(s.substeps, 8);
  EXPECT_EQ(s.iterations, 2);
  EXPECT_EQ(s.relax_iterations, 0);
  EXPECT_EQ(s.friction, FrictionModel::Pyramid);
  EXPECT_FALSE(s.warm_starting);
  EXPECT_EQ(s.tolerance, 0.001);
  EXPECT_EQ(s.stabilisation, Stabilisation::Baumgarte);
  EXPECT_EQ(s.correction, 0.3);
  EXPECT_EQ(s.slop, 0.25);
  EXPECT_EQ(s.contact_hertz, 60);
  EXPECT_EQ(s.contact_damping_ratio, 1);
  EXPECT_EQ(s.contact_push_speed, 2);
  EXPECT_EQ(s.restitution_threshold, 0.5);
  EXPECT_EQ(s.joint_solver, JointSolver::Direct);
  EXPECT_EQ(s.joint_hertz, 20);
  EXPECT_EQ(s.joint_damping_ratio, 3);
  EXPECT_TRUE(s.sleeping);
  EXPECT_EQ(s.sleep_speed, 0.1);
  EXPECT_EQ(s.time_to_sleep, 1);
}

TEST(SceneFile, ReadsEveryErrorThatATargetMayLimit) {
  const auto target = [](const std::string& members) {
    return parse(R"("settings": {"target": {)" + members + R"(}}, "bodies": [{)" + std::string(the_ball) + "}]")
        .settings.target;
  };
  const ErrorTarget all = target(R"("penetration": 0.001, "joint_gap": 0.002, "residual": 0.01, "motion": 0.003,
                                    "min_substeps": 3, "max_substeps": 200)");
  EXPECT_EQ(all.penetration, 0.001);
  EXPECT_EQ(all.joint_gap, 0.002);
  EXPECT_EQ(all.residual, 0.01);
  EXPECT_EQ(all.motion, 0.003);
  EXPECT_EQ(all.min_substeps, 3);
  EXPECT_EQ(all.max_substeps, 200);
  const ErrorTarget one = target(R"("residual": 0.1)");
  EXPECT_TRUE(one.is_set() && !one.penetration && !one.joint_gap && !one.motion);
  EXPECT_EQ(one.min_substeps, ErrorTarget{}.min_substeps);
  EXPECT_EQ(one.max_substeps, ErrorTarget{}.max_substeps);
  EXPECT_FALSE(target("").is_set());
}

TEST(SceneFile, ReadsEveryWayToSolve) {
  const auto settings = [](const std::string& key, const std::string& name) {
    return parse("\"settings\": {\"" + key + "\": \"" + name + "\"}, \"bodies\": [{" + the_ball + "}]").settings;
  };
  EXPECT_EQ(settings("stabilisation", "soft").stabilisation, Stabilisation::Soft);
  EXPECT_EQ(settings("stabilisation", "split_impulse").stabilisation, Stabilisation::SplitImpulse);
  EXPECT_EQ(settings("joint_solver", "auto").joint_solver, JointSolver::Auto);
  EXPECT_EQ(settings("joint_solver", "iterative").joint_solver, JointSolver::Iterative);
}

TEST(SceneFile, ReadsEveryFieldOfABody) {
  const BodyDef def = only_body(R"("type": "dynamic", "shape": {"type": "box", "half_extents": [1, 2, 3]},
                              "material": {"friction": 0.1, "restitution": 1, "rolling_friction": 0.02,
                                           "torsional_friction": 0.03},
                              "surface_velocity": [10, 11, 12], "position": [1, 2, 3],
                              "orientation": [0, 0, 2, 0], "velocity": [4, 5, 6], "angular_velocity": [7, 8, 9],
                              "mass": 3, "inertia": [2, 2, 3, 0.1, 0.2, 0.3],
                              "centre_of_mass": [0.1, 0.2, 0.3], "gravity_scale": -1,
                              "linear_damping": 0.5, "angular_damping": 0.25)");
  EXPECT_EQ(std::get<Box>(def.shape).half_extents, Vector3(1, 2, 3));
  EXPECT_EQ(def.material.friction, 0.1);
  EXPECT_EQ(def.material.restitution, 1);
  EXPECT_EQ(def.material.rolling_friction, 0.02);
  EXPECT_EQ(def.material.torsional_friction, 0.03);
  EXPECT_EQ(def.surface_velocity, Vector3(10, 11, 12));
  EXPECT_EQ(def.position, Vector3(1, 2, 3));
  EXPECT_EQ(def.orientation.coeffs(), Eigen::Vector4d(0, 0, 2, 0));
  EXPECT_EQ(def.velocity, Vector3(4, 5, 6));
  EXPECT_EQ(def.angular_velocity, Vector3(7, 8, 9));
  EXPECT_EQ(def.mass, 3);
  EXPECT_EQ(*def.inertia, (Matrix3() << 2, 0.1, 0.2, 0.1, 2, 0.3, 0.2, 0.3, 3).finished());
  EXPECT_EQ(*def.centre_of_mass, Vector3(0.1, 0.2, 0.3));
  EXPECT_EQ(def.gravity_scale, -1);
  EXPECT_EQ(def.linear_damping, 0.5);
  EXPECT_EQ(def.angular_damping, 0.25);
  EXPECT_EQ(only_body(std::string(the_ball) + R"(, "mass": 1, "inertia": [1, 1, 2])").inertia->diagonal(),
            Vector3(1, 1, 2));
  EXPECT_EQ(
      only_body(std::string(the_ball) + R"(, "type": "static", "surface_velocity": [1, 0, 0])").surface_velocity.x(),
      1);
  EXPECT_EQ(only_body(std::string(the_ball) + R"(, "type": "kinematic", "velocity": [1, 0, 0])").type,
            BodyType::Kinematic);
}

TEST(SceneFile, ReadsLocks) {
  const auto locks = [](const std::string& text) {
    return only_body(std::string(the_ball) + R"(, "locks": )" + text).locks;
  };
  EXPECT_EQ(only_body(std::string(the_ball)).locks, MotionLocks());
  EXPECT_EQ(locks("{}"), MotionLocks());
  EXPECT_EQ(locks(R"({"linear": ["z", "x"]})"), (MotionLocks{.linear = {true, false, true}}));
  EXPECT_EQ(locks(R"({"linear": [], "angular": ["y"]})"), (MotionLocks{.angular = {false, true, false}}));
  EXPECT_EQ(locks(R"({"plane": "x"})"), MotionLocks::plane(Axis::X));
  EXPECT_EQ(locks(R"({"plane": "z"})"), MotionLocks::plane(Axis::Z));
}

TEST(SceneFile, ReadsForces) {
  const Scene scene = parse(R"("bodies": [{)" + std::string(the_ball) + "}, {" + std::string(the_ball) +
                            R"(, "force": [1, -2, 3]}],
                               "generators": [{"count": [2, 1, 1], "body": {)" +
                            std::string(the_ball) + R"(, "force": [0, 0, 4]}}])");
  EXPECT_EQ(scene.bodies[0].force, Vector3::Zero());
  EXPECT_EQ(scene.bodies[1].force, Vector3(1, -2, 3));
  EXPECT_EQ(scene.bodies[2].force, Vector3(0, 0, 4));
  EXPECT_EQ(scene.bodies[3].force, Vector3(0, 0, 4));
}

TEST(SceneFile, NamesReferToTheLibrary) {
  const Scene scene = parse(R"("materials": {"ice": {"friction": 0}, "": {"friction": 2}},
                               "shapes": {"slope": {"type": "half_space", "normal": [1, 0, 1], "offset": 4}},
                               "bodies": [{"type": "static", "shape": "slope", "material": "ice"},
                                          {"type": "static", "shape": "slope", "material": ""}])");
  EXPECT_EQ(scene.bodies[0].def.material.friction, 0);
  EXPECT_EQ(scene.bodies[1].def.material.friction, 2);
  EXPECT_EQ(std::get<HalfSpace>(scene.bodies[0].def.shape).normal, Vector3(1, 0, 1));
  EXPECT_EQ(std::get<HalfSpace>(scene.bodies[0].def.shape).offset, 4);
}

TEST(SceneFile, ExamplesLoadWithoutOverlap) {
  const struct {
    const char* file;
    std::size_t bodies;
  } examples[] = {
      {"crates", 6}, {"walls", 25 * 55 + 1}, {"mixer", 8 * 8 * 6 + 4 * 4 * 6 + 6}, {"shapes", 10 + 3 * 3 * 5}};
  for (const auto& example : examples) {
    SCOPED_TRACE(example.file);
    const Scene scene = load_scene(std::string(ATOLL_SOURCE_DIR "/runtime/scene/examples/") + example.file + ".json");
    EXPECT_EQ(scene.name, example.file);
    EXPECT_EQ(scene.bodies.size(), example.bodies);
    EXPECT_EQ(measure_penetration(placed_shapes(scene)).pairs, 0u);
  }
}

TEST(SceneFile, FileThatIsNotThere) {
  EXPECT_THROW(load_scene("nowhere/none.json"), SceneError);
  test::expect_error([] { load_scene("nowhere/none.json"); }, {"nowhere/none.json", "No such file"});
}

TEST(SceneFile, PlacedShapesAreNormalised) {
  const Scene scene = parse(R"("bodies": [{"shape": {"type": "sphere", "radius": 1}, "position": [0, 0, 5],
                                           "orientation": [0, 0, 0, 3]}])");
  const std::vector<PlacedShape> shapes = placed_shapes(scene);
  ASSERT_EQ(shapes.size(), 1u);
  EXPECT_EQ(shapes[0].pose.position, Vector3(0, 0, 5));
  EXPECT_EQ(shapes[0].pose.orientation.coeffs(), Eigen::Vector4d(0, 0, 0, 1));
}

}  // namespace
}  // namespace atl
