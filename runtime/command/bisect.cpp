#include "bisect.h"

#include <atoll/error.h>
#include <atoll/first_difference.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "failure.h"
#include "names.h"
#include "option_checks.h"
#include "replay_report.h"
#include "standard_streams.h"
#include "view.h"

namespace atl::command {
namespace {

constexpr int shown_before = 60, shown_after = 60;  // steps of the page

FirstDifferenceResult first_difference_of(const BisectOptions& options) {
  try {
    return find_first_difference(options.first, options.second, {.threads = options.threads, .simd = options.simd});
  } catch (const Error& error) {
    throw Failure(Status::BadScene, error.what());
  }
}

std::string of_step(const FirstDifference& difference, std::int64_t step) {
  return "in " + std::string(phase_name(*difference.phase)) + " of step " + std::to_string(step);
}

std::string where_words(const FirstDifference& difference) {
  if (difference.by_calls) return "by calls ahead of step " + std::to_string(difference.step);
  return difference.phase ? of_step(difference, difference.step) : "in step " + std::to_string(difference.step);
}

void write_text(std::ostream& out, const BisectOptions& options, const FirstDifferenceResult& result) {
  out << "recordings " << options.first << "\n           " << options.second << "\n";
  if (!result.difference) {
    out << "result     same in " << plural(result.steps, "step") << ", bit for bit\n";
    return;
  }
  const FirstDifference& difference = *result.difference;
  out << "same       up to step " << difference.step - 1 << "\n"
      << "part       " << where_words(difference) << " (" << plural(result.replays, "replay") << ")\n";
  if (difference.bodies_step.value_or(-1) != difference.step) out << "           " << beside_bodies << "\n";
  if (difference.by_calls && difference.phase)
    out << "bodies     part " << of_step(difference, *difference.bodies_step) << "\n";
  write_bodies(out, difference.bodies);
}

// The second run around the step, beginning with it, and with the first body that differs picked.
void write_view(const BisectOptions& options, const FirstDifference& difference) {
  const auto step =
      static_cast<int>(std::min<std::int64_t>(difference.bodies_step.value_or(difference.step), max_steps));
  ViewOptions page;
  page.scene.text = options.second;
  page.threads = options.threads;
  page.simd = options.simd;
  page.page = options.view;
  page.from = std::max(0, step - shown_before);
  page.to = step + shown_after;
  page.place = "step=" + std::to_string(step);
  if (!difference.bodies.empty()) page.place += "&body=" + std::to_string(difference.bodies.front().id.index);
  view(page);
}

}  // namespace

void add_bisect_options(CLI::App& command, BisectOptions& options) {
  command.footer(
      "Where runs of other settings, machines or builds part: record each, and compare.\n"
      "\nExamples:\n"
      "  atoll run pile --record a.rec\n"
      "  atoll run pile --iterations 3 --record b.rec\n"
      "  atoll bisect a.rec b.rec --view parting.html");
  command.add_option("FIRST", options.first, "recording, as of atoll run --record")->check(file_name())->required();
  command.add_option("SECOND", options.second, "another one")->check(file_name())->required();
  command.add_option("--view", options.view, "write a page of the second around the step, which begins there")
      ->check(file_name())
      ->type_name("FILE.html");
  add_machine_options(command, options.threads, options.simd);
}

void bisect(const BisectOptions& options) {
  if (!options.view.empty()) page_file("--view", options.view);
  const FirstDifferenceResult result = first_difference_of(options);
  write_text(std::cout, options, result);
  if (result.difference && !options.view.empty()) write_view(options, *result.difference);
  finish_output();
  if (!result.difference) return;
  const FirstDifference& difference = *result.difference;
  throw Failure(Status::CheckFailed,
                options.second + ": parts from " + options.first + " " + where_words(difference) +
                    (difference.bodies.empty() ? "" : ", " + body_words(difference.bodies.front())));
}

}  // namespace atl::command
