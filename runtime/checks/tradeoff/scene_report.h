#pragma once

#include <string>
#include <vector>

#include "comparison.h"
#include "grid.h"
#include "record.h"

namespace atl::tradeoff {

/// All that a sweep found out about one scene.
struct SceneReport {
  ScenePlan plan;
  std::vector<Record> records;          ///< Atoll's default first, then its others, then engine by engine
  std::vector<Comparison> comparisons;  ///< by measure; the first is the one to look at
  std::string view = "";                ///< file of the page that plays it, if there is one
};

/// Compares by every measure that some run has: the closed form's error first, else the mean gap of joints, else
/// mean penetration. Overlaps of what still falls are compared, but not judged.
void compare_all(SceneReport& report);

/// "m", "rad" or "".
std::string unit_of(const std::string& measure, const std::vector<Record>& records);

}  // namespace atl::tradeoff
