#include "bisect.h"

#include <atoll/error.h>
#include <atoll/parting.h>

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

PartingResult parting_of(const BisectOptions& options) {
  try {
    return find_parting(options.first, options.second, {.threads = options.threads, .simd = options.simd});
  } catch (const Error& error) {
    throw Failure(Status::BadScene, error.what());
  }
}

std::string of_step(const Parting& parting, std::int64_t step) {
  return "in " + std::string(phase_name(*parting.phase)) + " of step " + std::to_string(step);
}

std::string where_words(const Parting& parting) {
  if (parting.by_calls) return "by calls ahead of step " + std::to_string(parting.step);
  return parting.phase ? of_step(parting, parting.step) : "in step " + std::to_string(parting.step);
}

void write_text(std::ostream& out, const BisectOptions& options, const PartingResult& result) {
  out << "recordings " << options.first << "\n           " << options.second << "\n";
  if (!result.parting) {
    out << "result     same in " << plural(result.steps, "step") << ", bit for bit\n";
    return;
  }
  const Parting& parting = *result.parting;
  out << "same       up to step " << parting.step - 1 << "\n"
      << "part       " << where_words(parting) << " (" << plural(result.replays, "replay") << ")\n";
  if (parting.bodies_step.value_or(-1) != parting.step) out << "           " << beside_bodies << "\n";
  if (parting.by_calls && parting.phase) out << "bodies     part " << of_step(parting, *parting.bodies_step) << "\n";
  write_bodies(out, parting.bodies);
}

// The second run around the step, beginning with it, and with the first body that differs picked.
void write_view(const BisectOptions& options, const Parting& parting) {
  const auto step = static_cast<int>(std::min<std::int64_t>(parting.bodies_step.value_or(parting.step), most_steps));
  ViewOptions page;
  page.scene.text = options.second;
  page.threads = options.threads;
  page.simd = options.simd;
  page.page = options.view;
  page.from = std::max(0, step - shown_before);
  page.to = step + shown_after;
  page.place = "step=" + std::to_string(step);
  if (!parting.bodies.empty()) page.place += "&body=" + std::to_string(parting.bodies.front().id.index);
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
  const PartingResult result = parting_of(options);
  write_text(std::cout, options, result);
  if (result.parting && !options.view.empty()) write_view(options, *result.parting);
  finish_output();
  if (!result.parting) return;
  const Parting& parting = *result.parting;
  throw Failure(Status::CheckFailed, options.second + ": parts from " + options.first + " " + where_words(parting) +
                                         (parting.bodies.empty() ? "" : ", " + body_words(parting.bodies.front())));
}

}  // namespace atl::command
