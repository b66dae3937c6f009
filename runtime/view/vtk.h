#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "view/surfaces.h"
#include "view/watcher.h"

namespace atl::view {

/// True if the build has HDF5: ATOLL_BUILD_VTK.
bool has_vtk();

struct VtkOptions {
  std::int64_t first_step = 0;  ///< steps made ahead of the first frame
  int stride = 1;               ///< steps a frame, >= 1
};

/// A run as files of VTKHDF (version 1.0, UnstructuredGrid), one a frame, which ParaView opens as a series from version
/// 5.10 on. Cells are the triangles of all bodies, then a vertex for each point of contact that carries force.
///
/// Data of points: `velocity` (m/s, of the surface; 0 at contacts), `contact_force` (N, friction with it, on the second
/// body; 0 on surfaces). Data of cells: `body` (BodyId::index; for contacts the second), `kind` (0 static, 1 kinematic,
/// 2 dynamic, 3 contact), `asleep`, `normal_force` (N: the sum on a body, or that of the point), `separation` (m, as
/// the step started; 0 for bodies) and, where the contact problem is kept, `contact_residual` (m/s, the largest of a
/// body's contacts, see measure_contact_residual(); 0 for contacts). Data of the frame: `time` (s, since the first
/// frame), `step`.
class VtkSeries : public Watcher {
 public:
  /// Writes a frame, given its step and the bytes of a file.
  using Sink = std::function<void(std::int64_t step, const std::vector<char>& bytes)>;

  VtkSeries(const VtkOptions& options, Sink sink);

  void begin(const World& world) override { write_frame(world); }
  void add(const World& world, const StepReport& report, double dt) override;

  std::size_t frames() const { return frames_; }

 private:
  void write_frame(const World& world);

  FrameClock clock_;
  Surfaces surfaces_;
  Sink sink_;
  std::size_t frames_ = 0;
};

}  // namespace atl::view
