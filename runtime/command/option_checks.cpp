#include "option_checks.h"

#include <atoll/step_length.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>

#include "checks/tradeoff/target_text.h"

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

CLI::Validator length_above_zero() {
  const auto check = [](std::string& text) -> std::string {
    const double value = tradeoff::parse_metres(text);
    if (value > 0 && std::isfinite(value)) return "";
    return "found \"" + text + "\", expected a length above 0, as 1mm or 0.001";
  };
  return {check, "", "length"};
}

CLI::Validator seconds_a_step() {
  const auto check = [](std::string& text) -> std::string {
    const double value = parse_seconds(text);
    if (!(value >= shortest_step && value <= longest_step)) {
      return "found \"" + text + "\", expected a number in [1e-12, 1], as 1/60 or 0.01";
    }
    text = shortest(value);
    return "";
  };
  return {check, "[1e-12, 1]", "seconds"};
}

CLI::Validator error_target() {
  const auto check = [](std::string& text) -> std::string {
    ErrorTarget target;
    return tradeoff::read_target(text, target);
  };
  return {check, "", "target"};
}

CLI::Validator seed_number() {
  const auto check = [](std::string& text) -> std::string {
    std::uint64_t value = 0;
    if (parse_whole(text, value)) return "";
    return "found \"" + text + "\", expected an integer in [0, 2^64)";
  };
  return {check, "[0, 2^64)", "seed"};
}

CLI::Validator file_name() {
  const auto check = [](std::string& text) -> std::string { return text.empty() ? "expected a file name" : ""; };
  return {check, "", "file name"};
}

CLI::Option* add_choice(CLI::App& command, const char* option, const std::vector<std::string>& names, const char* help,
                        const std::function<void(const std::string&)>& set) {
  std::string words;
  for (const std::string& name : names) words += (words.empty() ? "" : "|") + name;
  const auto check = [names, words](std::string& text) -> std::string {
    if (std::find(names.begin(), names.end(), text) != names.end()) return "";
    return "found \"" + text + "\", expected " + words;
  };
  return command.add_option_function<std::string>(option, set, help)
      ->check(CLI::Validator(check, "", "choice"))
      ->type_name(words);
}

}  // namespace atl::command
