#include "checks/tradeoff/target_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "checks/tradeoff/number_text.h"

namespace atl::tradeoff {
namespace {

struct Limit {
  const char* name;
  const char* words;
  std::optional<double> ErrorTarget::*member;
  bool length;      // in m, or m/s
  const char* per;  // what follows the metres in its unit
  const char* expected;
};

constexpr std::array limits = {
    Limit{"penetration", "penetration", &ErrorTarget::penetration, true, "", "a length above 0, as 1mm or 0.001"},
    Limit{"joint_gap", "joint gap", &ErrorTarget::joint_gap, true, "", "a length above 0, as 1mm or 0.001"},
    Limit{"residual", "residual", &ErrorTarget::residual, false, "", "a finite number > 0"},
    Limit{"motion", "motion", &ErrorTarget::motion, true, "/s", "a speed above 0, as 1mm/s or 0.001"}};

double read_limit(const Limit& limit, const std::string& text) {
  if (limit.length) return parse_metres(text, limit.per);
  double value = 0;
  return parse_whole(text, value) ? value : std::nan("");
}

bool is_limit(double value) { return std::isfinite(value) && value > 0; }

// "penetration=1mm".
std::string read_entry(const std::string& entry, ErrorTarget& target) {
  const std::size_t equals = entry.find('=');
  for (const Limit& limit : limits) {
    if (entry.substr(0, equals) != limit.name) continue;
    const std::string value = equals == std::string::npos ? "" : entry.substr(equals + 1);
    const double read = read_limit(limit, value);
    if (!is_limit(read)) return std::string(limit.name) + ": found \"" + value + "\", expected " + limit.expected;
    if (target.*limit.member) return "found " + std::string(limit.name) + " twice, expected it once";
    target.*limit.member = read;
    return "";
  }
  return "found \"" + entry +
         "\", expected a length as 1mm or 0.001, off, or a list of penetration=, joint_gap=, residual= and motion=";
}

std::string limit_words(const Limit& limit, double value) {
  if (!limit.length) return shortest(value);
  // To six digits: what was read as millimetres may be a bit off in metres.
  const double rounded = std::round(1e9 * value) / 1e6;
  return shortest(rounded > 0 ? rounded : 1e3 * value) + " mm" + limit.per;
}

}  // namespace

std::string read_target(const std::string& text, ErrorTarget& target) {
  ErrorTarget read = {.min_substeps = target.min_substeps, .max_substeps = target.max_substeps};
  if (const double length = parse_metres(text); is_limit(length)) {
    read.penetration = read.joint_gap = length;
  } else if (text != "off") {
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t end = std::min(text.find(',', begin), text.size());
      const std::string wrong = read_entry(text.substr(begin, end - begin), read);
      if (!wrong.empty()) return wrong;
      begin = end + 1;
    }
  }
  target = read;
  return "";
}

std::string target_words(const ErrorTarget& target) {
  if (!target.is_set()) return "off";
  if (target.penetration && target.penetration == target.joint_gap && !target.residual && !target.motion) {
    return limit_words(limits[0], *target.penetration);
  }
  std::string words;
  for (const Limit& limit : limits) {
    const std::optional<double>& value = target.*limit.member;
    if (value) words += (words.empty() ? "" : ", ") + std::string(limit.words) + " " + limit_words(limit, *value);
  }
  return words;
}

}  // namespace atl::tradeoff
