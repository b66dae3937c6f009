#include "checks/tradeoff/number_text.h"

#include <array>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace atl::tradeoff {

double parse_seconds(const std::string& text) {
  const std::size_t slash = text.find('/');
  double value = 0, divisor = 1;
  const bool whole = parse_whole(text.substr(0, slash), value) &&
                     (slash == std::string::npos || parse_whole(text.substr(slash + 1), divisor));
  return whole ? value / divisor : std::nan("");
}

double parse_metres(const std::string& text, std::string_view per) {
  struct Unit {
    std::string_view name;
    double of_metre;  // so many
  };
  constexpr std::array units = {Unit{"m", 1}, Unit{"mm", 1e3}, Unit{"um", 1e6}};
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) return std::nan("");
  std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
  if (unit.empty()) return value;
  if (unit.starts_with(' ')) unit.remove_prefix(1);
  if (!unit.ends_with(per)) return std::nan("");
  unit.remove_suffix(per.size());
  for (const auto& [name, of_metre] : units) {
    if (unit == name) return value / of_metre;
  }
  return std::nan("");
}

std::string shortest(double value) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end.ptr};
}

std::string plural(std::int64_t count, const std::string& one, const std::string& more) {
  return std::to_string(count) + " " + (count == 1 ? one : more);
}
std::string plural(std::int64_t count, const std::string& noun) { return plural(count, noun, noun + "s"); }

std::string exact(double value) {
  std::ostringstream text;
  text << std::setprecision(17) << value;
  return text.str();
}

std::string fixed(double value, int decimals) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(decimals) << value;
  return text.str();
}

}  // namespace atl::tradeoff
