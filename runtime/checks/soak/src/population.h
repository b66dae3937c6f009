#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "things.h"
#include "twin.h"
#include "yard.h"

namespace atl::soak {

/// Steps that a thing stays.
inline constexpr std::int64_t shortest_stay = 300, longest_stay = 900;

/// A thing that is there.
struct Resident {
  std::size_t kind = 0;
  const char* name = "";
  std::vector<BodyId> bodies = {};
  std::vector<double> masses = {};  ///< kg, as it came
  std::vector<JointId> joints = {};
  std::int64_t until = 0;  ///< the step ahead of which it goes, or, of none, another one may come
};

/// Things that come and go: as one goes, another of its kind comes, so that there are about as many of all at any time.
/// A thing comes to a place in which there is nothing, or waits.
class Population {
 public:
  Population(Twin& twin, Random& random);

  void come_and_go(std::int64_t step, SoakTally& tally);
  /// Takes the thing out that the body is a part of; nothing if it is of none.
  void remove_with(BodyId body, std::int64_t step, SoakTally& tally);
  /// The name of the thing that the body is a part of: "yard" if it was there from the start.
  const char* name_of(BodyId body) const;

  const std::vector<Resident>& residents() const { return residents_; }
  /// One that is there, with dynamic bodies; none if the draw fell on another.
  const Resident* draw();
  /// A dynamic body of one.
  std::optional<BodyId> draw_body();

 private:
  bool come(Resident& resident, std::int64_t step, SoakTally& tally);
  void go(Resident& resident, std::int64_t step, SoakTally& tally);
  std::optional<Pose> free_place(const Thing& thing);

  Twin& twin_;
  Random& random_;
  std::vector<Resident> residents_;
};

}  // namespace atl::soak
