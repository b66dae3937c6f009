#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <system_error>

namespace atl::tradeoff {

/// Reads a number that is all of the text.
template <class Number>
bool parse_whole(const std::string& text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

/// A number of seconds, or a fraction, as 1/60; NaN if it is neither.
double parse_seconds(const std::string& text);

/// A length with or without its unit, as "1mm", "5um", "0.1 m" or "0.001", in m; of a speed `per` is "/s". NaN if it is
/// none.
double parse_metres(const std::string& text, std::string_view per = "");

/// The shortest text that reads back as the same number.
std::string shortest(double value);
/// 17 significant digits, which do too.
std::string exact(double value);
/// A fixed number of decimals, as "3.140".
std::string fixed(double value, int decimals);

/// "1 step", "2 steps".
std::string plural(std::int64_t count, const std::string& one, const std::string& more);
std::string plural(std::int64_t count, const std::string& noun);

}  // namespace atl::tradeoff
