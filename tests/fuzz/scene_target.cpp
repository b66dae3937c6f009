// Scene files. What is read is built, stepped, written as a scene file again, and read from that to the same.

#include <atoll/scene.h>

#include <string>
#include <string_view>

#include "few_steps.h"
#include "finding.h"
#include "target.h"

namespace {

constexpr std::size_t most_bodies = 2000;

void run(std::string_view text) {
  using namespace atl;
  const Scene scene = parse_scene(text, "input");
  if (scene.bodies.size() > most_bodies) return;
  const std::string written = scene_text(scene);
  std::string again;
  try {
    again = scene_text(parse_scene(written, "written"));
  } catch (const Error& error) {
    throw fuzz::Finding(std::string("a scene that was read and written is refused: ") + error.what());
  }
  fuzz::require(again == written, "a scene that was written and read is written otherwise");
  World world({.gravity = scene.gravity, .settings = scene.settings});
  build_scene(scene, world);
  fuzz::few_steps(world, 2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    run({reinterpret_cast<const char*>(data), size});
  } catch (const atl::Error&) {
  }
  return 0;
}
