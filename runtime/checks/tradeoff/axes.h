#pragma once

#include <atoll/settings.h>

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace atl::tradeoff {

/// One way to run a scene in Atoll: a place on every axis.
struct Configuration {
  Settings settings = {};
  double dt = 0;  ///< s
  int threads = 1;
};

/// A knob that a sweep turns. Values are texts, as an option has them.
struct Axis {
  const char* name;      ///< as in results; the option is "--" and this with dashes
  const char* help;      ///< of the option
  bool numeric;          ///< its values are numbers
  bool changes_result;   ///< else it changes the time alone, and not a bit of the result
  const char* expected;  ///< "an integer in [1, 1024]"
  bool (*accepts)(const std::string& value);
  void (*apply)(const std::string& value, Configuration& configuration);
  std::string (*value)(const Configuration& configuration);  ///< where a configuration lies
  std::string (*label)(const Configuration& configuration);  ///< the same in words, as "8 substeps"
};

/// All of them; what is added here is an option, a column and part of a label.
std::span<const Axis> axes();

const Axis& find_axis(std::string_view name);

/// "friction_x" as "--friction-x".
std::string option_of(const Axis& axis);

bool same_place(const Configuration& a, const Configuration& b);

/// Names the differences from the scene's own configuration: "default", or for instance "8 substeps, pyramid friction".
std::string label_of(const Configuration& configuration, const Configuration& scenes_own);

/// Instruction sets that this machine and build have, the portable code first.
std::vector<std::string> available_simds();

}  // namespace atl::tradeoff
