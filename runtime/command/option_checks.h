#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "checks/tradeoff/number_text.h"

namespace atl::command {

using tradeoff::parse_seconds;
using tradeoff::parse_whole;
using tradeoff::shortest;

/// Checks of an option's text that say what was found and what was expected. (CLI11's own Range lets NaN pass and does
/// not say what it wants of a text that is no number.)
CLI::Validator integer_in(int min, int max);
CLI::Validator number_above_zero(double max);
CLI::Validator number_above_zero();
CLI::Validator number_not_below_zero();
CLI::Validator length_above_zero();  ///< in m, or with a unit
CLI::Validator seconds_a_step();     ///< turns a fraction into a number
CLI::Validator error_target();       ///< see tradeoff::read_target()
CLI::Validator seed_number();
CLI::Validator file_name();

/// An option that takes one of a few words, which its help lists.
CLI::Option* add_choice(CLI::App& command, const char* option, const std::vector<std::string>& names, const char* help,
                        const std::function<void(const std::string&)>& set);

constexpr int max_threads = 1024;
constexpr int max_steps = 1'000'000'000;

}  // namespace atl::command
