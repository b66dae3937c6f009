#include "checks/tradeoff/axes.h"

#include <atoll/step_length.h>
#include <atoll/world.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "checks/tradeoff/number_text.h"
#include "checks/tradeoff/setting_names.h"
#include "checks/tradeoff/target_text.h"

namespace atl::tradeoff {
namespace {

template <int min, int max>
bool accepts_integer(const std::string& text) {
  int value = 0;
  return parse_whole(text, value) && value >= min && value <= max;
}

int integer(const std::string& text) {
  int value = 0;
  parse_whole(text, value);
  return value;
}

bool accepts_speed(const std::string& text) {
  double value = 0;
  return parse_whole(text, value) && std::isfinite(value) && value >= 0;
}

double number(const std::string& text) {
  double value = 0;
  parse_whole(text, value);
  return value;
}

bool accepts_seconds(const std::string& text) {
  const double seconds = parse_seconds(text);
  return seconds >= shortest_step && seconds <= longest_step;
}

std::string step_label(const Configuration& c) {
  const double rate = 1 / c.dt;
  const bool whole = std::abs(rate - std::round(rate)) < 1e-9 * rate;
  return "dt " + (whole ? "1/" + std::to_string(std::lround(rate)) : shortest(c.dt)) + " s";
}

std::string joint_solver_name(const Configuration& c) { return name_of(c.settings.joint_solver); }
std::string contact_solver_name(const Configuration& c) { return name_of(c.settings.contact_solver); }

bool accepts_target(const std::string& value) {
  ErrorTarget target;
  return value.find('=') == std::string::npos && read_target(value, target).empty();
}

// A length where that is all it is, as the option has it, to the last digit.
std::string target_value(const Configuration& c) {
  const ErrorTarget& target = c.settings.target;
  const bool length =
      target.penetration && target.penetration == target.joint_gap && !target.residual && !target.motion;
  return length ? shortest(*target.penetration) : target_words(target);
}

const char* on_off(bool on) { return on ? "on" : "off"; }

constexpr std::array table = {
    Axis{.name = "substeps",
         .help = "substeps a step",
         .numeric = true,
         .changes_result = true,
         .expected = "an integer in [1, 1024]",
         .accepts = accepts_integer<1, 1024>,
         .apply = [](const std::string& value, Configuration& c) { c.settings.substeps = integer(value); },
         .value = [](const Configuration& c) { return std::to_string(c.settings.substeps); },
         .label = [](const Configuration& c) { return plural(c.settings.substeps, "substep"); }},
    Axis{.name = "target",
         .help = "m that penetrations and gaps of joints are held below, each island in the fewest substeps, as 1mm or "
                 "0.001; off: all get the same",
         .numeric = false,
         .changes_result = true,
         .expected = "a length above 0, as 1mm or 0.001, or off",
         .accepts = accepts_target,
         .apply = [](const std::string& value, Configuration& c) { read_target(value, c.settings.target); },
         .value = target_value,
         .label = [](const Configuration& c) { return "target " + target_words(c.settings.target); }},
    Axis{.name = "iterations",
         .help = "sweeps over the contacts and joints a substep",
         .numeric = true,
         .changes_result = true,
         .expected = "an integer in [1, 1024]",
         .accepts = accepts_integer<1, 1024>,
         .apply = [](const std::string& value, Configuration& c) { c.settings.iterations = integer(value); },
         .value = [](const Configuration& c) { return std::to_string(c.settings.iterations); },
         .label = [](const Configuration& c) { return plural(c.settings.iterations, "iteration"); }},
    Axis{.name = "dt",
         .help = "s of simulated time a step, as 1/60 or 0.01; the steps change with it, the simulated time stays",
         .numeric = true,
         .changes_result = true,
         .expected = "a number in [1e-12, 1], as 1/60 or 0.01",
         .accepts = accepts_seconds,
         .apply = [](const std::string& value, Configuration& c) { c.dt = parse_seconds(value); },
         .value = [](const Configuration& c) { return shortest(c.dt); },
         .label = step_label},
    Axis{.name = "friction",
         .help = "friction models",
         .numeric = false,
         .changes_result = true,
         .expected = "cone or pyramid",
         .accepts = [](const std::string& value) { return value == "cone" || value == "pyramid"; },
         .apply = [](const std::string& value, Configuration& c) { c.settings.friction = friction_named(value); },
         .value = [](const Configuration& c) { return std::string(name_of(c.settings.friction)); },
         .label = [](const Configuration& c) { return "friction " + std::string(name_of(c.settings.friction)); }},
    Axis{.name = "warm_start",
         .help = "whether a step starts from the impulses of the one before",
         .numeric = false,
         .changes_result = true,
         .expected = "on or off",
         .accepts = [](const std::string& value) { return value == "on" || value == "off"; },
         .apply = [](const std::string& value, Configuration& c) { c.settings.warm_starting = value == "on"; },
         .value = [](const Configuration& c) { return std::string(on_off(c.settings.warm_starting)); },
         .label = [](const Configuration& c) { return std::string("warm start ") + on_off(c.settings.warm_starting); }},
    Axis{.name = "relax_iterations",
         .help = "sweeps without position bias a substep",
         .numeric = true,
         .changes_result = true,
         .expected = "an integer in [0, 1024]",
         .accepts = accepts_integer<0, 1024>,
         .apply = [](const std::string& value, Configuration& c) { c.settings.relax_iterations = integer(value); },
         .value = [](const Configuration& c) { return std::to_string(c.settings.relax_iterations); },
         .label = [](const Configuration& c) { return plural(c.settings.relax_iterations, "relax iteration"); }},
    Axis{.name = "stabilisation",
         .help = "how contacts get bodies apart",
         .numeric = false,
         .changes_result = true,
         .expected = "soft, baumgarte or split_impulse",
         .accepts =
             [](const std::string& value) {
               return value == "soft" || value == "baumgarte" || value == "split_impulse";
             },
         .apply = [](const std::string& value,
                     Configuration& c) { c.settings.stabilisation = stabilisation_named(value); },
         .value = [](const Configuration& c) { return std::string(name_of(c.settings.stabilisation)); },
         .label = [](const Configuration& c) { return std::string(name_of(c.settings.stabilisation)); }},
    Axis{.name = "contact_solver",
         .help = "how contacts are solved that carry more than sweeps can hold up",
         .numeric = false,
         .changes_result = true,
         .expected = "auto, iterative or direct",
         .accepts = is_contact_solver,
         .apply = [](const std::string& value,
                     Configuration& c) { c.settings.contact_solver = contact_solver_named(value); },
         .value = contact_solver_name,
         .label = [](const Configuration& c) { return contact_solver_name(c) + " contacts"; }},
    Axis{.name = "joint_solver",
         .help = "how joints are solved; by default in scenes where that makes a difference",
         .numeric = false,
         .changes_result = true,
         .expected = "auto, iterative or direct",
         .accepts = is_joint_solver,
         .apply = [](const std::string& value,
                     Configuration& c) { c.settings.joint_solver = joint_solver_named(value); },
         .value = joint_solver_name,
         .label = [](const Configuration& c) { return joint_solver_name(c) + " joints"; }},
    Axis{.name = "tolerance",
         .help = "m/s; sweeps of an island end with one that changes no speed at a contact or joint by more, 0: never; "
                 "with the "
                 "most iterations of that list",
         .numeric = true,
         .changes_result = true,
         .expected = "a finite number >= 0",
         .accepts = accepts_speed,
         .apply = [](const std::string& value, Configuration& c) { c.settings.tolerance = number(value); },
         .value = [](const Configuration& c) { return shortest(c.settings.tolerance); },
         .label = [](const Configuration& c) { return "tolerance " + shortest(c.settings.tolerance) + " m/s"; }},
    Axis{.name = "threads",
         .help = "worker threads",
         .numeric = true,
         .changes_result = false,
         .expected = "an integer in [1, 1024]",
         .accepts = accepts_integer<1, 1024>,
         .apply = [](const std::string& value, Configuration& c) { c.threads = integer(value); },
         .value = [](const Configuration& c) { return std::to_string(c.threads); },
         .label = [](const Configuration& c) { return plural(c.threads, "thread"); }},
    Axis{.name = "simd",
         .help = "vector instructions of the solver",
         .numeric = false,
         .changes_result = false,
         .expected = "auto, portable, sse4, avx2, avx512 or neon, as far as this machine has it",
         .accepts =
             [](const std::string& value) {
               const std::vector<std::string> all = available_simds();
               return value == "auto" || std::find(all.begin(), all.end(), value) != all.end();
             },
         .apply = [](const std::string& value, Configuration& c) { c.settings.simd = simd_named(value); },
         .value = [](const Configuration& c) { return std::string(name_of(c.settings.simd)); },
         .label = [](const Configuration& c) { return std::string(name_of(c.settings.simd)); }},
};

}  // namespace

std::span<const Axis> axes() { return table; }

const Axis& find_axis(std::string_view name) {
  for (const Axis& axis : table) {
    if (axis.name == name) return axis;
  }
  throw std::logic_error("there is no axis " + std::string(name));
}

std::string option_of(const Axis& axis) {
  std::string option = std::string("--") + axis.name;
  std::replace(option.begin(), option.end(), '_', '-');
  return option;
}

bool same_place(const Configuration& a, const Configuration& b) {
  return std::all_of(table.begin(), table.end(), [&](const Axis& axis) { return axis.value(a) == axis.value(b); });
}

std::string label_of(const Configuration& configuration, const Configuration& scenes_own) {
  std::string label;
  for (const Axis& axis : table) {
    if (axis.value(configuration) == axis.value(scenes_own)) continue;
    label += (label.empty() ? "" : ", ") + axis.label(configuration);
  }
  return label.empty() ? "default" : label;
}

std::vector<std::string> available_simds() {
  std::vector<std::string> available;
  for (const Simd simd : {Simd::Portable, Simd::Sse4, Simd::Avx2, Simd::Avx512, Simd::Neon}) {
    try {
      WorldDef def;
      def.settings.simd = simd;
      const World world(def);
      available.push_back(name_of(simd));
    } catch (const Error&) {
      // This machine or build lacks it.
    }
  }
  return available;
}

}  // namespace atl::tradeoff
