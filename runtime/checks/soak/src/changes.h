#pragma once

#include <atoll/world.h>

#include <cstdint>
#include <vector>

#include "population.h"

namespace atl::soak {

/// Steps until all choices of settings came once: they come in turn.
inline constexpr std::int64_t settings_cycle = 2100;

/// All else that is done to what is there: what definitions said, motion, filters, joints, ropes between things,
/// settings.
class Changes {
 public:
  Changes(Twin& twin, Population& population, Random& random);

  void make(std::int64_t step, SoakTally& tally);
  const char* settings_name() const;  ///< of those in use
  bool asks_functions() const { return asks_functions_; }

 private:
  void change_body();
  void move_body();
  void change_joint();
  void change_filters();
  void change_settings();
  void tie(std::int64_t step, SoakTally& tally);

  // Between two bodies of other things.
  struct Rope {
    JointId joint;
    std::int64_t until;
  };

  Twin& twin_;
  Population& population_;
  Random& random_;
  std::vector<Rope> ropes_;
  std::size_t choice_ = 0;  // of settings
  bool asks_functions_ = false;
};

/// The functions that are set for a while: bodies of one user data pass through each other, others slide better.
void set_functions(World& world, bool set);

}  // namespace atl::soak
