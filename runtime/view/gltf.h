#pragma once

#include <atoll/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

#include "view/surfaces.h"
#include "view/watcher.h"

namespace atl::view {

struct GltfOptions {
  std::string name = {};        ///< of the run
  std::int64_t first_step = 0;  ///< steps made ahead of the first frame
  int stride = 1;               ///< steps a frame, >= 1
};

/// A run as an animated scene of glTF 2.0 (Khronos, ISO/IEC 12113): a mesh a shape, a node a body with its name, its
/// place and turn by frames, and a scale of 0 while it isn't there. Metres, and seconds since the first frame; y is up
/// there, so all is below a node that turns z to it. A half-space is a square of 200 m.
class GltfFilm : public Watcher {
 public:
  explicit GltfFilm(GltfOptions options);

  void begin(const World& world) override { add_frame(world); }
  void add(const World& world, const StepReport& report, double dt) override;

  std::size_t frames() const { return times_.size(); }
  /// Writes one binary file (.glb), or JSON with all data in it (.gltf). Throws Error if it can't be written.
  void write(std::ostream& out, bool binary) const;

 private:
  struct Body {
    std::string name;
    std::uint32_t surface;
    bool moves;  // it isn't static
    std::size_t first_frame;
    std::vector<std::array<float, 3>> positions;  // m, by frame from the first on, as long as it was there
    std::vector<std::array<float, 4>> turns;      // x, y, z, w
  };
  class Writer;

  void add_frame(const World& world);

  GltfOptions options_;
  FrameClock clock_;
  Surfaces surfaces_;
  std::vector<float> times_;              // s
  std::vector<Body> bodies_;              // in the order in which they came
  std::map<BodyId, std::size_t> places_;  // in bodies_, of those that are there
};

}  // namespace atl::view
