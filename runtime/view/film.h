#pragma once

#include <atoll/body.h>
#include <atoll/joint.h>
#include <atoll/report.h>
#include <atoll/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "view/film_chunk.h"
#include "view/film_contacts.h"
#include "view/film_shapes.h"
#include "view/watcher.h"

namespace atl {
class World;
}

namespace atl::view {

/// Another page about the same run.
struct RelatedPage {
  std::string text = {};     ///< of the link
  std::string address = {};  ///< "" where there is none
};

struct FilmOptions {
  std::string name = {};        ///< of the run, for the page's title
  RelatedPage related = {};     ///< linked in the page's head
  std::string place = {};       ///< what the page shows first, as after the # of its address
  std::int64_t first_step = 0;  ///< steps made ahead of the first frame
  int stride = 1;               ///< steps a frame, >= 1
  /// m, > 0: what places are rounded to. By default a 1000th of the size of the middle one of the dynamic bodies that
  /// there are at first, as a power of two.
  std::optional<double> precision = {};
  /// From the frame on at which there are more, contact points are left out: 100,000 take 1 to 2 MB of the page.
  std::size_t max_contacts = 200'000;
};

/// A body of a film: its place among them is its number.
struct FilmBody {
  BodyId id;
  std::string name;
  std::uint32_t shape = 0;  ///< in FilmShapes
  BodyType type = BodyType::Dynamic;
  double mass = 0;  ///< kg; infinite unless dynamic
  Material material;
  bool sensor = false;
};

struct FilmJoint {
  JointId id;
  const char* kind = "";                ///< "ball", "hinge", ...
  std::uint32_t first = 0, second = 0;  ///< numbers of bodies
  Vector3 anchor_first, anchor_second;  ///< m, frames of the bodies
  std::size_t from = 0, to = 0;         ///< frames [from, to)
};

/// The data of a frame as a whole.
struct FilmFrame {
  std::int64_t step = 0;  ///< steps done
  double time = 0;        ///< s
  double ms = 0;          ///< of the last one
  std::array<double, phase_count> phase_ms = {};
  double overlap = 0;    ///< m, the deepest of contact points that carry force, as the step began
  double joint_gap = 0;  ///< m, the largest between the origins of the two frames of a joint that holds a point
  std::int64_t contacts = 0, islands = 0, asleep = 0;
};

/// A run, as it is looked at: which bodies there were, and for each frame where they were, what they felt and what the
/// step took. Looks at the world and changes nothing of it.
class Film : public Watcher {
 public:
  explicit Film(FilmOptions options);

  /// The world ahead of the first step.
  void begin(const World& world) override { add_frame(world, nullptr); }
  /// The world after a step of dt seconds. Every stride-th is kept.
  void add(const World& world, const StepReport& report, double dt) override;

  /// One JSON object, as page/film.js reads it: chunks and geometry in it are base64 of zlib streams.
  std::string text();

  const std::vector<FilmBody>& bodies() const { return bodies_; }
  std::size_t frames() const { return frames_.size(); }
  double precision() const { return precision_; }  ///< m

 private:
  void add_frame(const World& world, const StepReport* report);
  void number_bodies(const World& world, const std::vector<BodyId>& ids);
  void record_joints(const World& world, FilmFrame& frame);
  void record_forces(const World& world, FilmFrame& frame);
  void record_contacts(const World& world);
  void record_bodies(const World& world, const std::vector<BodyId>& ids);

  FilmOptions options_;
  double precision_ = 0;
  FrameClock clock_;
  std::vector<FilmBody> bodies_;
  std::vector<std::uint32_t> numbers_;  // by BodyId::index, of the body that has it now
  FilmShapes shapes_;
  std::vector<FilmJoint> joints_;
  std::map<JointId, std::size_t> present_joints_;  // their places in joints_
  std::vector<FilmFrame> frames_;
  FilmChunks chunks_;
  FilmContacts contacts_;
  std::vector<BodySight> sights_;  // scratch, by number
};

}  // namespace atl::view
