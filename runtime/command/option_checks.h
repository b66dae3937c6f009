#pragma once

#include <CLI/CLI.hpp>
#include <charconv>
#include <functional>
#include <string>
#include <vector>

namespace atl::command {

/// Reads a number that is all of the text.
template <class Number>
bool parse_whole(const std::string& text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

/// A number of seconds, or a fraction, as 1/60; NaN if it is neither.
double parse_seconds(const std::string& text);
/// The shortest text that reads back as the same number.
std::string shortest(double value);

/// Checks of an option's text that say what was found and what was expected. (CLI11's own Range lets NaN pass and does
/// not say what it wants of a text that is no number.)
CLI::Validator integer_in(int min, int max);
CLI::Validator number_above_zero(double max);
CLI::Validator number_above_zero();
CLI::Validator number_not_below_zero();
CLI::Validator seconds_a_step();  ///< turns a fraction into a number
CLI::Validator seed_number();
CLI::Validator file_name();

/// An option that takes one of a few words, which its help lists.
CLI::Option* add_choice(CLI::App& command, const char* option, const std::vector<std::string>& names, const char* help,
                        const std::function<void(const std::string&)>& set);

constexpr int most_threads = 1024;
constexpr int most_steps = 1'000'000'000;

}  // namespace atl::command
