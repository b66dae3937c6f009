#include "option_checks.h"

#include <cmath>
#include <cstdint>
#include <sstream>

namespace atl::command {

CLI::Validator integer_in(int min, int max) {
  const std::string range = "[" + std::to_string(min) + ", " + std::to_string(max) + "]";
  const auto check = [=](std::string& text) -> std::string {
    int value = 0;
    if (parse_whole(text, value) && value >= min && value <= max) return "";
    return "found \"" + text + "\", expected an integer in " + range;
  };
  return {check, range, "integer"};
}

CLI::Validator number_above_zero(double max) {
  std::ostringstream range;
  range << "(0, " << max << "]";
  const auto check = [max, range = range.str()](std::string& text) -> std::string {
    double value = 0;
    if (parse_whole(text, value) && value > 0 && value <= max) return "";
    return "found \"" + text + "\", expected a number in " + range;
  };
  return {check, range.str(), "number above zero"};
}

CLI::Validator number_above_zero() {
  const auto check = [](std::string& text) -> std::string {
    double value = 0;
    if (parse_whole(text, value) && value > 0 && std::isfinite(value)) return "";
    return "found \"" + text + "\", expected a finite number > 0";
  };
  return {check, "> 0", "number above zero"};
}

CLI::Validator number_not_below_zero() {
  const auto check = [](std::string& text) -> std::string {
    double value = 0;
    if (parse_whole(text, value) && value >= 0 && std::isfinite(value)) return "";
    return "found \"" + text + "\", expected a finite number >= 0";
  };
  return {check, ">= 0", "number not below zero"};
}

CLI::Validator seed_number() {
  const auto check = [](std::string& text) -> std::string {
    std::uint64_t value = 0;
    if (parse_whole(text, value)) return "";
    return "found \"" + text + "\", expected an integer in [0, 2^64)";
  };
  return {check, "[0, 2^64)", "seed"};
}

}  // namespace atl::command
