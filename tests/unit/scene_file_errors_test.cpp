// Everything a scene file can get wrong: one line, with the place, what was found and what was expected.

#include <atoll/scene.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace atl {
namespace {

std::string message_for(const std::string& text) {
  try {
    parse_scene(text, "bad.json");
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

struct Refused {
  std::string text;
  std::string starts;    ///< of the message: place and what was found
  std::string contains;  ///< what was expected
};

void expect_refused(const Refused& refused) {
  SCOPED_TRACE(refused.text.substr(0, 300));
  const std::string message = message_for(refused.text);
  EXPECT_TRUE(message.starts_with("bad.json:" + refused.starts)) << message;
  EXPECT_NE(message.find("expected " + refused.contains), std::string::npos) << message;
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 0) << message;
}

// The members of a file that is right otherwise, from its second line.
std::string scene(const std::string& members) {
  return "{\"format\": \"atoll-scene\", \"version\": 1,\n" + members + "}";
}
std::string body(const std::string& members) { return scene("\"bodies\": [{\n" + members + "}]"); }
std::string ball(const std::string& members) {
  return body(R"("shape": {"type": "sphere", "radius": 0.5}, )" + members);
}
std::string settings(const std::string& members) { return scene("\"settings\": {" + members + "}"); }
std::string generator(const std::string& members) {
  return scene(R"("generators": [{"body": {"shape": {"type": "sphere", "radius": 1}}, )" + members + "}]");
}

TEST(SceneFileErrors, NotJson) {
  const Refused cases[] = {
      {"", "1:1: found end of input", ""},
      {"{\"format\": \"atoll-sc", "1:21: found an invalid string: missing closing quote", "valid JSON"},
      {"{\"bodies\": [\n  {\"name\": \"a\"},\n", "3:1: found end of input", ""},
      {"{\"bodies\": [1, 2", "1:17: found end of input", "']'"},
      {"{\"a\": 1,}", "1:9: found '}'", "string literal"},
      {"{\"a\": 1}\n}", "2:1: found '}'", "end of input"},
      {"{\n\"a\": NaN}", "2:6: found \"NaN\"", "valid JSON"},
      {"{\"a\": Infinity}", "1:7: found \"Infinity\"", "valid JSON"},
      {"{\"a\": -Infinity}", "1:8: found \"-Infinity\"", "valid JSON"},
      {"{\"a\": 1e999}", "1:11: found \"1e999\"", "a number that a double can hold"},
      {"{\"a\": -1e999}", "1:12: found \"-1e999\"", "a number that a double can hold"},
      {"{\"a\": \"x\ny\"}", "1:9: found an invalid string: control character", "valid JSON"},
      {"{\"a\": \"\xff\"}", "1:8: found an invalid string: ill-formed UTF-8", "valid JSON"},
      {"// comment\n{}", "1:1: found \"/\"", "valid JSON"},
      {std::string(1000, '['), "1: found values nested more than 64 deep", ""},
  };
  for (const Refused& refused : cases) expect_refused(refused);
}

TEST(SceneFileErrors, KeysGivenTwice) {
  const Refused cases[] = {
      {scene("\"steps\": 1,\n\"steps\": 1"), "3: /steps: found the key a second time", "every key of an object once"},
      {ball(R"("mass": 1, "mass": 1)"), "3: /bodies/0/mass: found the key a second time", ""},
      {scene(R"("shapes": {"a": {}, "a": {}})"), "2: /shapes/a: found the key a second time", ""},
  };
  for (const Refused& refused : cases) expect_refused(refused);
}

TEST(SceneFileErrors, Format) {
  const Refused cases[] = {
      {"[1]", "1: found an array of 1", "an object"},
      {"3", "1: found 3", "an object"},
      {"{}", "1: /format: found nothing", "\"atoll-scene\""},
      {R"({"format": "scene"})", "1: /format: found \"scene\"", "\"atoll-scene\""},
      {R"({"format": 1})", "1: /format: found 1", "\"atoll-scene\""},
      {R"({"format": "atoll-scene"})", "1: /version: found nothing", "1"},
      {R"({"format": "atoll-scene", "version": 2})", "1: /version: found 2", "1"},
      {R"({"format": "atoll-scene", "version": "1"})", "1: /version: found \"1\"", "1"},
  };
  for (const Refused& refused : cases) expect_refused(refused);
}

TEST(SceneFileErrors, World) {
  const Refused cases[] = {
      {scene(R"("gravty": 1)"), "2: /gravty: found the unknown key \"gravty\"", "format, version, name"},
      {scene(R"("a/b~c": 1)"), "2: /a~1b~0c: found the unknown key \"a/b~c\"", ""},
      {scene(R"("a\nb": 1)"), R"(2: /a\u000ab: found the unknown key "a\x0ab")", ""},
      {scene(R"("gravity": 9.81)"), "2: /gravity: found 9.81", "an array of three numbers"},
      {scene(R"("gravity": [0, 0])"), "2: /gravity: found an array of 2", "an array of three numbers"},
      {scene(R"("gravity": [0, 0, "x"])"), "2: /gravity/2: found \"x\"", "a number"},
      {scene(R"("dt": 0)"), "2: /dt: found 0", "a number in [1e-12, 1]"},
      {scene(R"("dt": 1.5)"), "2: /dt: found 1.5", "a number in [1e-12, 1]"},
      {scene(R"("steps": 0)"), "2: /steps: found 0", "an integer in [1, 1000000000]"},
      {scene(R"("steps": 2.5)"), "2: /steps: found 2.5", "an integer"},
      {scene(R"("steps": true)"), "2: /steps: found true", "an integer"},
      {scene(R"("steps": null)"), "2: /steps: found null", "an integer"},
      {scene(R"("name": {})"), "2: /name: found an object", "a string"},
      {scene(R"("description": 1)"), "2: /description: found 1", "a string"},
      {scene(R"("starts_at_rest": "yes")"), "2: /starts_at_rest: found \"yes\"", "true or false"},
      {scene(R"("materials": [])"), "2: /materials: found an empty array", "an object"},
      {scene(R"("bodies": {})"), "2: /bodies: found an object", "an array of bodies"},
      {scene(R"("bodies": [])"), "2: /bodies: found no bodies", "at least one"},
      {scene(R"("bodies": [3])"), "2: /bodies/0: found 3", "an object"},
  };
  for (const Refused& refused : cases) expect_refused(refused);
  EXPECT_TRUE(message_for(scene(R"("gravty": 1)")).ends_with("(did you mean \"gravity\"?)"));
}

TEST(SceneFileErrors, Settings) {
  const Refused cases[] = {
      {settings(R"("substep": 1)"), "2: /settings/substep: found the unknown key", "substeps, target, iterations"},
      {settings(R"("simd": "avx2")"), "2: /settings/simd: found the unknown key", ""},
      {settings(R"("substeps": 0)"), "2: /settings/substeps: found 0", "an integer in [1, 1024]"},
      {settings(R"("iterations": 1025)"), "2: /settings/iterations: found 1025", "an integer in [1, 1024]"},
      {settings(R"("relax_iterations": -1)"), "2: /settings/relax_iterations: found -1", "an integer in [0, 1024]"},
      {settings(R"("friction": "cones")"), "2: /settings/friction: found \"cones\"", "cone or pyramid (did you mean"},
      {settings(R"("friction": 0.5)"), "2: /settings/friction: found 0.5", "cone or pyramid"},
      {settings(R"("warm_starting": 1)"), "2: /settings/warm_starting: found 1", "true or false"},
      {settings(R"("tolerance": -1)"), "2: /settings/tolerance: found -1", "a number >= 0"},
      {settings(R"("stabilisation": "split")"), "2: /settings/stabilisation: found \"split\"",
       "soft, baumgarte or split_impulse (did you mean \"split_impulse\"?)"},
      {settings(R"("correction": 0)"), "2: /settings/correction: found 0", "a number in (0, 1]"},
      {settings(R"("correction": 1.5)"), "2: /settings/correction: found 1.5", "a number in (0, 1]"},
      {settings(R"("slop": -1)"), "2: /settings/slop: found -1", "a number >= 0"},
      {settings(R"("profile": true)"), "2: /settings/profile: found the unknown key", ""},
      {settings(R"("contact_hertz": 0)"), "2: /settings/contact_hertz: found 0", "a number > 0"},
      {settings(R"("contact_damping_ratio": -1)"), "2: /settings/contact_damping_ratio: found -1", "a number >= 0"},
      {settings(R"("contact_push_speed": 0)"), "2: /settings/contact_push_speed: found 0", "a number > 0"},
      {settings(R"("restitution_threshold": -1)"), "2: /settings/restitution_threshold: found -1", "a number >= 0"},
      {settings(R"("joint_solver": "exact")"), "2: /settings/joint_solver: found \"exact\"",
       "auto, iterative or direct"},
      {settings(R"("joint_hertz": 0)"), "2: /settings/joint_hertz: found 0", "a number > 0"},
      {settings(R"("joint_damping_ratio": -1)"), "2: /settings/joint_damping_ratio: found -1", "a number >= 0"},
      {settings(R"("sleep_speed": -1)"), "2: /settings/sleep_speed: found -1", "a number >= 0"},
      {settings(R"("time_to_sleep": -1)"), "2: /settings/time_to_sleep: found -1", "a number >= 0"},
  };
  for (const Refused& refused : cases) expect_refused(refused);
}

TEST(SceneFileErrors, Targets) {
  const auto target = [](const std::string& members, const std::string& others = "") {
    return settings("\"target\": {\n" + members + "}" + others);
  };
  const Refused cases[] = {
      {settings(R"("target": 0.001)"), "2: /settings/target: found 0.001", "an object"},
      {target(R"("penetrations": 1)"), "3: /settings/target/penetrations: found the unknown key", "penetration"},
      {target(R"("penetration": 0)"), "3: /settings/target/penetration: found 0", "a number > 0"},
      {target(R"("joint_gap": -1)"), "3: /settings/target/joint_gap: found -1", "a number > 0"},
      {target(R"("residual": "1 %")"), "3: /settings/target/residual: found \"1 %\"", "a number > 0"},
      {target(R"("motion": 0)"), "3: /settings/target/motion: found 0", "a number > 0"},
      {target(R"("min_substeps": 0)"), "3: /settings/target/min_substeps: found 0", "an integer in [1, 1024]"},
      {target(R"("max_substeps": 1025)"), "3: /settings/target/max_substeps: found 1025", "an integer in [1, 1024]"},
      {target(R"("min_substeps": 8, "max_substeps": 4)"), "3: /settings/target/max_substeps: found 4",
       "min_substeps, 8, or more"},
      {target(R"("min_substeps": 200)"), "2: /settings/target/max_substeps: found 128, the default,",
       "min_substeps, 200, or more"},
      {target(R"("motion": 1)", R"(, "stabilisation": "baumgarte")"),
       "2: /settings/target: found it with rigid stabilisation", "it with \"soft\" only"},
      {target(R"("penetration": 1)", R"(, "contact_hertz": 30)"),
       "3: /settings/target/penetration: found it and contact_hertz", "one of them"},
      {target(R"("joint_gap": 1)", R"(, "joint_hertz": 30)"), "3: /settings/target/joint_gap: found it and joint_hertz",
       "one of them"},
  };
  for (const Refused& refused : cases) expect_refused(refused);
  // Without a target, no setting contradicts it.
  const std::string unset = target(R"("min_substeps": 4)", R"(, "stabilisation": "baumgarte")");
  EXPECT_NE(message_for(unset).find("/bodies"), std::string::npos) << message_for(unset);
}

TEST(SceneFileErrors, ShapesAndMaterials) {
  const Refused cases[] = {
      {body(R"("name": "a")"), "2: /bodies/0/shape: found nothing", "a shape or the name of one"},
      {body(R"("shape": 1)"), "3: /bodies/0/shape: found 1", "an object"},
      {body(R"("shape": {"radius": 1})"), "3: /bodies/0/shape/type: found nothing", "box, sphere, capsule"},
      {body(R"("shape": {"type": "bax"})"), "3: /bodies/0/shape/type: found \"bax\"",
       "box, sphere, capsule, cylinder, cone, ellipsoid, tapered_capsule, hull, half_space, mesh, height_field or "
       "compound "
       "(did"},
      {body(R"("shape": {"type": "box"})"), "3: /bodies/0/shape/half_extents: found nothing", "[x, y, z] in m"},
      {body(R"("shape": {"type": "box", "half_extents": [1, 0, 1]})"), "3: /bodies/0/shape/half_extents/1: found 0",
       "a number > 0"},
      {body(R"("shape": {"type": "box", "half_extents": [1, 1, 1], "radius": 1})"),
       "3: /bodies/0/shape/radius: found the unknown key", "type or half_extents"},
      {body(R"("shape": {"type": "sphere"})"), "3: /bodies/0/shape/radius: found nothing", "a number > 0, in m"},
      {body(R"("shape": {"type": "sphere", "radius": -1})"), "3: /bodies/0/shape/radius: found -1", "a number > 0"},
      {body(R"("type": "static", "shape": {"type": "half_space", "normal": [0, 0, 0]})"),
       "3: /bodies/0/shape/normal: found a vector of length 0", "a length above 0"},
      {body(R"("shape": {"type": "half_space"})"), "3: /bodies/0/shape: found a half-space on a dynamic body",
       "a solid"},
      {body(R"("shape": "crate")"), "3: /bodies/0/shape: found \"crate\"", "the name of a shape in /shapes"},
      {scene(R"("shapes": {"crate": {"type": "sphere", "radius": 1}}, "bodies": [{"shape": "crte"}])"),
       "2: /bodies/0/shape: found \"crte\"",
       "the name of a shape in /shapes, which has crate (did you mean \"crate\"?)"},
      {scene(R"("shapes": {"crate": {"type": "sphere", "radius": 0}})"), "2: /shapes/crate/radius: found 0",
       "a number"},
      {ball(R"("material": "ice")"), "3: /bodies/0/material: found \"ice\"", "the name of a material in /materials"},
      {ball(R"("material": {"frction": 1})"), "3: /bodies/0/material/frction: found the unknown key",
       "friction, friction_across, friction_direction, restitution, rolling_friction, torsional_friction, "
       "friction_rule, restitution_rule or id"},
      {ball(R"("material": {"friction": -0.1})"), "3: /bodies/0/material/friction: found -0.1", "a number >= 0"},
      {ball(R"("material": {"rolling_friction": -1})"), "3: /bodies/0/material/rolling_friction: found -1",
       "a number >= 0"},
      {ball(R"("material": {"torsional_friction": -1})"), "3: /bodies/0/material/torsional_friction: found -1",
       "a number >= 0"},
      {ball(R"("surface_velocity": [1, 0])"), "3: /bodies/0/surface_velocity: found an array of 2",
       "an array of three"},
      {ball(R"("material": {"restitution": 2})"), "3: /bodies/0/material/restitution: found 2", "a number in [0, 1]"},
  };
  for (const Refused& refused : cases) expect_refused(refused);
}

TEST(SceneFileErrors, Bodies) {
  const Refused cases[] = {
      {ball(R"("velocty": [0, 0, 0])"), "3: /bodies/0/velocty: found the unknown key", "name, type, shape"},
      {ball(R"("type": "fixed")"), "3: /bodies/0/type: found \"fixed\"", "dynamic, static or kinematic"},
      {ball(R"("position": [0, 0, 0, 0])"), "3: /bodies/0/position: found an array of 4", "an array of three"},
      {ball(R"("orientation": [0, 0, 0])"), "3: /bodies/0/orientation: found an array of 3", "a quaternion"},
      {ball(R"("orientation": [0, 0, 0, 0])"), "3: /bodies/0/orientation: found a quaternion of norm 0", "a norm"},
      {ball(R"("type": "static", "velocity": [0, 0, 1])"), "3: /bodies/0/velocity: found it on a static body", "it on"},
      {ball(R"("density": 0)"), "3: /bodies/0/density: found 0", "a number > 0"},
      {ball(R"("mass": -5)"), "3: /bodies/0/mass: found -5", "a number > 0"},
      {ball(R"("mass": 5, "density": 5)"), "3: /bodies/0/mass: found both a mass and a density", "one of them"},
      {ball(R"("inertia": [1, 1, 1])"), "2: /bodies/0/mass: found an inertia without a mass", "both"},
      {ball(R"("mass": 1, "centre_of_mass": [0, 0, 1])"), "2: /bodies/0/inertia: found a centre of mass without",
       "both"},
      {ball(R"("type": "kinematic", "force": [1, 0, 0])"), "3: /bodies/0/force: found it on a body that is not dynamic",
       "it on dynamic bodies only"},
      {ball(R"("type": "static", "locks": {})"), "3: /bodies/0/locks: found it on a body that is not dynamic", "it on"},
      {ball(R"("locks": ["x"])"), "3: /bodies/0/locks: found", "an object"},
      {ball(R"("locks": {"planar": "x"})"), "3: /bodies/0/locks/planar: found the unknown key", "linear, angular"},
      {ball(R"("locks": {"plane": "w"})"), "3: /bodies/0/locks/plane: found \"w\"", "x, y or z"},
      {ball(R"("locks": {"plane": "x", "linear": ["x"]})"), "3: /bodies/0/locks/linear: found both it and a plane",
       "a plane, or else"},
      {ball(R"("locks": {"linear": "x"})"), "3: /bodies/0/locks/linear: found", "an array of axes"},
      {ball(R"("locks": {"angular": ["x", "u"]})"), "3: /bodies/0/locks/angular/1: found \"u\"", "x, y or z"},
      {ball(R"("locks": {"angular": ["x", "x"]})"), "3: /bodies/0/locks/angular/1: found an axis that is there already",
       "each of them once"},
      {ball(R"("force": 5)"), "3: /bodies/0/force: found 5", "an array of three numbers"},
      {ball(R"("type": "kinematic", "mass": 5)"), "3: /bodies/0/mass: found it on a body that is not dynamic", "it on"},
      {ball(R"("mass": 1, "inertia": [1, 1])"), "3: /bodies/0/inertia: found an array of 2", "an array of three"},
      {ball(R"("mass": 1, "inertia": [1, 1, 0])"), "3: /bodies/0/inertia: found principal moments 0, 1, 1", "all of"},
      {ball(R"("mass": 1, "inertia": [1, 1, 1, 2, 0, 0])"), "3: /bodies/0/inertia: found principal moments", "all of"},
      {ball(R"("mass": 1, "inertia": [1, 1, 2.5])"), "3: /bodies/0/inertia: found principal moments", "none larger"},
      {ball(R"("linear_damping": -1)"), "3: /bodies/0/linear_damping: found -1", "a number >= 0"},
      {ball(R"("angular_damping": -1)"), "3: /bodies/0/angular_damping: found -1", "a number >= 0"},
      {scene(R"("shapes": {"s": {"type": "sphere", "radius": 1}},
                "bodies": [{"name": "a", "shape": "s"},
                           {"name": "a", "shape": "s"}])"),
       "4: /bodies/1/name: found a second body named \"a\"", "a name that no other body has"},
  };
  for (const Refused& refused : cases) expect_refused(refused);
}

TEST(SceneFileErrors, Generators) {
  const Refused cases[] = {
      {scene(R"("generators": [{"count": [1, 1, 1]}])"), "2: /generators/0/body: found nothing", "a body to repeat"},
      {generator(R"("spacing": [1, 1, 1])"), "2: /generators/0/count: found nothing", "[x, y, layers]"},
      {generator(R"("count": [1, 1])"), "2: /generators/0/count: found an array of 2", "an array of three integers"},
      {generator(R"("count": [1, 0, 1])"), "2: /generators/0/count/1: found 0", "an integer in [1, 10000000]"},
      {generator(R"("count": [1, 1, 1], "spcing": 1)"), "2: /generators/0/spcing: found the unknown key",
       "body, count"},
      {generator(R"("count": [3, 1, 4], "taper": [1, 0])"), "2: /generators/0/taper/0: found 1", "a taper that leaves"},
      {generator(R"("count": [3, 1, 2], "taper": [-1, 0])"), "2: /generators/0/taper/0: found -1", "an integer in"},
      {generator(R"("count": [1, 1, 1], "stagger": [0, 2])"), "2: /generators/0/stagger/1: found 2", "a number in [-1"},
      {generator(R"("count": [1, 1, 1], "jitter": [0, -1, 0])"), "2: /generators/0/jitter/1: found -1",
       "a number >= 0"},
      {generator(R"("count": [1, 1, 1], "copies": {"count": [1, 1, 1], "taper": [0, 0]})"),
       "2: /generators/0/copies/taper: found the unknown key", "count or spacing"},
      {generator(R"("count": [10000000, 10000000, 10000000])"), "2: /generators/0/count: found 1e+21 bodies",
       "at most"},
      {generator(R"("count": [3000, 3000, 1], "copies": {"count": [2, 1, 1]})"),
       "2: /generators/0/count: found 18000000 bodies", "at most 10000000 more"},
      {generator(R"("count": [1, 1, 9], "spacing": [1, 1, 1e308])"), "2: /generators/0: found positions too large", ""},
      {scene(R"("generators": [{"body": {"name": "a", "shape": {"type": "sphere", "radius": 1}}, "count": [2, 1, 1]},
                {"body": {"name": "a", "shape": {"type": "sphere", "radius": 1}}, "count": [1, 1, 1]}])"),
       "3: /generators/1/body/name: found a second body named \"a_0\"", "a name that no other body has"},
      {scene(R"("generators": [{"body": {"shape": {"type": "sphere", "radius": 1}, "orientation": [0, 0, 0, 1]},
                "count": [2, 1, 1], "random_orientation": true}])"),
       "3: /generators/0/random_orientation: found it for a body with an orientation", "one of them"},
  };
  for (const Refused& refused : cases) expect_refused(refused);
}

TEST(SceneFileErrors, LongTextIsCutOff) {
  const std::string message = message_for(ball("\"type\": \"" + std::string(100000, 'x') + "\""));
  EXPECT_LT(message.size(), 300u);
}

}  // namespace
}  // namespace atl
