#pragma once

#include <atoll/body.h>
#include <atoll/closed_form.h>
#include <atoll/errors.h>
#include <atoll/joint.h>
#include <atoll/settings.h>
#include <atoll/step_length.h>
#include <atoll/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace atl {

class World;

/// A body of a scene: its definition and its name ("" or unique within the scene).
struct SceneBody {
  std::string name = {};
  BodyDef def = {};
  Vector3 force = Vector3::Zero();  ///< N, world frame, through the centre of mass, in every step
};

/// A joint of a scene: its definition, whose ids of bodies and joints stand open, its name ("" or unique among the
/// joints), and the bodies by their places in the scene.
struct SceneJoint {
  std::string name = {};
  JointDef def = {};
  std::size_t first = 0;
  std::size_t second = 0;
  std::vector<std::size_t> terms = {};  ///< of a tendon: the joint of each term, by its place, ahead of its own
};

/// A world to simulate, as data: what a scene file or a built-in scene turns into.
struct Scene {
  std::string name = {};
  Vector3 gravity = {0, 0, -9.81};
  double dt = 1.0 / 60;
  int steps = 300;
  Settings settings = {};
  /// The bodies start in their ideal rest pose, so sink, drift and tilt are errors.
  bool starts_at_rest = false;
  std::vector<MaterialPair> material_pairs = {};
  std::vector<SceneBody> bodies = {};
  std::vector<SceneJoint> joints = {};
  std::optional<ClosedForm> closed_form = {};  ///< of a scene whose motion is known
};

/// Thrown for a scene that cannot be read. what() is one line: the file (or the scene's name), the JSON
/// pointer or line, what was found and what was expected.
class SceneError : public Error {
 public:
  /// Control characters of the message, as names in the file may have, become \xNN, and the middle of a long one "...".
  explicit SceneError(const std::string& message);
};

/// Thrown for a built-in scene that would need more memory than there is, before any is taken: what it needs, about,
/// and what there is. (A file of which that is so is a SceneError.)
class SceneTooLarge : public SceneError {
 public:
  using SceneError::SceneError;
};

/// A parameter of a built-in scene.
struct SceneParameter {
  std::string name;
  double value;  ///< default
  double min, max;
  bool integer;
  std::string help;
};

struct BuiltinScene {
  std::string name;
  std::string help;
  std::vector<SceneParameter> parameters;
};

/// All built-in scenes, in the order to show them.
const std::vector<BuiltinScene>& builtin_scenes();

/// The files of meshes and hulls that a scene file may name.
enum class MeshFiles {
  BelowScene,  ///< in the scene file's folder or below it, links followed
  Anywhere,    ///< for scene files that are trusted
};

/// A built-in scene from "name" or "name:param=value,param=value" (as "pyramid3d:layers=18"), or a scene
/// file where the text ends in ".json" or names an existing file. `seed` feeds the scenes that have
/// random content; the same seed gives the same scene on every machine. Files have at most 1 GiB each. Throws
/// SceneError.
Scene load_scene(std::string_view text, std::uint64_t seed = 1, MeshFiles files = MeshFiles::BelowScene);

/// A scene file's text, `origin` naming it in messages; mesh files are relative to its folder. Throws SceneError.
Scene parse_scene(std::string_view json, const std::string& origin, std::uint64_t seed = 1,
                  MeshFiles files = MeshFiles::BelowScene);

/// A world as a scene, as it is now: its bodies in order of their indices and the joints that are enabled. What scenes
/// have no words for stays behind: impulses to start from, who sleeps or is in quarantine, forces of the next step, and
/// pairs that World::set_collision_enabled keeps apart. Snapshots have all of it. Of `dt` and `steps` a world knows
/// nothing: they are a Scene's.
Scene scene_of(const World& world);

/// A scene as the text of a scene file, all of it written out: bodies, shapes with their geometry, joints by the frames
/// of their bodies, settings but for those that say what is told. Numbers are read back as the same bits; throws
/// SceneError on one that is not finite, as of a body that an impulse was too large for.
std::string scene_text(const Scene& scene);
/// The same as a file, which is whole or not there. Throws SceneError if it can't be written.
void write_scene(const Scene& scene, const std::string& path);
/// The text of "settings" in a scene file.
std::string settings_text(const Settings& settings);

/// Adds all bodies and then all joints in order; returns the ids of the bodies. Throws SceneError naming the body or
/// the joint.
std::vector<BodyId> build_scene(const Scene& scene, World& world);
/// The same, which also tells the ids of the joints.
std::vector<BodyId> build_scene(const Scene& scene, World& world, std::vector<JointId>& joints);

/// Gives the scene's constant forces to the world's next step.
void apply_forces(const Scene& scene, World& world, const std::vector<BodyId>& ids);

/// States of the scene's bodies in the world, in the scene's order.
std::vector<BodyState> body_states(const World& world, const std::vector<BodyId>& ids);
/// Forces between them as of the end of the last step, in order of pairs of body ids.
std::vector<ContactLoad> contact_loads(const World& world, const std::vector<BodyId>& ids);

/// Shapes at the scene's starting poses, and at a world's current ones, for the error measures.
std::vector<PlacedShape> placed_shapes(const Scene& scene);
std::vector<PlacedShape> placed_shapes(const Scene& scene, const World& world, const std::vector<BodyId>& ids);

/// The joints of dynamic bodies, for the error measures.
std::vector<PlacedJoint> placed_joints(const Scene& scene);

/// Which of the bodies may touch, by their filters and joints. Keeps a copy of these.
MayTouch may_touch(const Scene& scene);

}  // namespace atl
