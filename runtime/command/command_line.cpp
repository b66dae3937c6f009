#include "command_line.h"

#include <atoll/scene.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bisect.h"
#include "explain.h"
#include "failure.h"
#include "interrupt.h"
#include "list_scenes.h"
#include "python_command.h"
#include "replay.h"
#include "run.h"
#include "scene/src/words.h"
#include "soak.h"
#include "standard_streams.h"
#include "sweep/sweep.h"
#include "tune.h"
#include "verify/verify.h"
#include "view.h"

namespace atl::command {
namespace {

int exit_with(Status status, const std::string& message) {
  std::cerr << "atoll: " << scene::printable(message) << "\n";
  return static_cast<int>(status);
}

int exit_with(const Failure& failure) { return exit_with(failure.status(), failure.what()); }

std::vector<std::string_view> views(const std::vector<std::string>& texts) { return {texts.begin(), texts.end()}; }

// The first argument that is not understood, what could stand there, and which of these may be meant.
std::string words_of_extra(const CLI::App& app, std::span<const char* const> arguments) {
  const std::vector<std::string> extras = app.remaining(true);
  const auto found = std::find_first_of(arguments.begin(), arguments.end(), extras.begin(), extras.end());
  if (found == arguments.end()) return "an argument is not understood";
  const std::string extra = *found;
  const auto parsed = app.get_subcommands();
  const CLI::App& command = parsed.empty() ? app : *parsed.front();
  std::vector<std::string> names;
  if (extra.starts_with("-")) {
    for (const CLI::Option* option : command.get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
    return "unknown option \"" + extra + "\"" + scene::suggestion(extra.substr(0, extra.find('=')), views(names));
  }
  if (!parsed.empty()) return "unexpected argument \"" + extra + "\"";
  for (const CLI::App* each : app.get_subcommands({})) names.push_back(each->get_name());
  return "unknown command \"" + extra +
         "\", expected run, view, explain, replay, bisect, soak, sweep, tune, ensemble, import, verify or scenes" +
         scene::suggestion(extra, views(names));
}

int usage_error(const CLI::ParseError& error, const CLI::App& app, std::span<const char* const> arguments) {
  std::string message = error.what();
  message = message.substr(0, message.find('\n'));
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) message = words_of_extra(app, arguments);
  std::string command = "atoll";
  for (const CLI::App* parsed : app.get_subcommands()) command += " " + parsed->get_name();
  return exit_with(Status::Usage, message + " (see " + command + " --help)");
}

// Parses and runs; what goes wrong is thrown, but for help and usage, which CLI11 words.
int run_parsed(int argc, char** argv) {
  CLI::App app("Atoll: deterministic, island-parallel rigid-body simulation.", "atoll");
  app.set_version_flag("--version", "atoll " ATOLL_VERSION);
  app.footer(
      "Examples:\n"
      "  atoll scenes                  what there is to run\n"
      "  atoll run pile --threads 2    5000 boxes dropped into a container\n"
      "  atoll run wall:base=100       a built-in scene with another parameter\n"
      "\nExit status: 0 done, 1 a check failed, 2 usage, 3 bad scene or recording, 4 a body became non-finite; "
      "130 interrupted\n(143 by SIGTERM, 129 by SIGHUP): what was done by then is printed and written.");

  CLI::App* run = app.add_subcommand("run", "simulate a scene file or a built-in scene and report time and error");
  RunOptions options;
  add_run_options(*run, options);
  CLI::App* viewing = app.add_subcommand(
      "view", "run a scene or a recording and write a page that plays it, a picture, or files for other programs");
  ViewOptions view_options;
  add_view_options(*viewing, view_options);
  CLI::App* explanation =
      app.add_subcommand("explain", "run a scene and tell what its steps need, what they leave out, and why");
  ExplainOptions explain_options;
  add_explain_options(*explanation, explain_options);
  CLI::App* replay =
      app.add_subcommand("replay", "make the calls of a recording again and tell where the state differs");
  ReplayFileOptions replay_options;
  add_replay_options(*replay, replay_options);
  CLI::App* bisecting =
      app.add_subcommand("bisect", "tell in which step two recordings part, in what of it, and of which bodies");
  BisectOptions bisect_options;
  add_bisect_options(*bisecting, bisect_options);
  CLI::App* soaking = app.add_subcommand(
      "soak", "let bodies and joints come and go for hours, in two worlds, and tell what goes wrong");
  SoakCommandOptions soak_options;
  add_soak_options(*soaking, soak_options);
  CLI::App* sweep = app.add_subcommand("sweep", "run scenes over many settings and draw error against run time");
  SweepOptions sweep_options;
  add_sweep_options(*sweep, sweep_options);
  CLI::App* tuning = app.add_subcommand("tune", "find the cheapest fixed settings that hold a scene's errors");
  TuneOptions tune_options;
  add_tune_options(*tuning, tune_options);
  // For the list of commands: what follows these two is for Python, see run_command_line().
  app.add_subcommand("ensemble", "run thousands of simulations of a plan, on one machine, with Ray or with Slurm");
  app.add_subcommand("import", "make a scene file of a robot model (URDF, MJCF)");
  CLI::App* verification = app.add_subcommand("verify", "run checks of the simulation and tell what fails");
  VerifyOptions verify_options;
  add_verify_options(*verification, verify_options);
  CLI::App* scenes = app.add_subcommand("scenes", "list the built-in scenes and their parameters, or write one out");
  std::string scene_to_write;
  scenes->add_option("SCENE", scene_to_write, "write it as a scene file, to edit and run");
  scenes->footer(
      "Examples:\n"
      "  atoll scenes                                   all built-in scenes\n"
      "  atoll scenes wall:base=10 > wall.json          one as a file\n"
      "  atoll run wall.json");

  try {
    app.parse(argc, argv);
    // CLI11's require_subcommand would hide that "atoll rnu" has an argument that is not understood.
    if (app.get_subcommands().empty()) std::cout << app.help();
    if (run->parsed()) command::run(options);
    if (viewing->parsed()) command::view(view_options);
    if (explanation->parsed()) command::explain(explain_options);
    if (replay->parsed()) replay_file(replay_options);
    if (bisecting->parsed()) bisect(bisect_options);
    if (soaking->parsed()) command::soak(soak_options);
    if (sweep->parsed()) command::sweep(sweep_options);
    if (tuning->parsed()) command::tune(tune_options);
    if (verification->parsed()) verify(verify_options);
    if (scenes->parsed() && scene_to_write.empty()) list_scenes(std::cout);
    if (!scene_to_write.empty()) std::cout << scene_text(load_scene(scene_to_write));
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) return usage_error(error, app, std::span(argv + 1, argv + argc));
    app.exit(error);
  }
  finish_output();
  return static_cast<int>(Status::Done);
}

}  // namespace

int run_command_line(int argc, char** argv) {
  try {
    if (is_python_command(argc, argv)) run_python_command(argv);
    prepare_standard_streams();
    catch_interrupts();
    return run_parsed(argc, argv);
  } catch (const ReaderGone&) {
    return end_by_closed_pipe();
  } catch (const SceneTooLarge& error) {
    return exit_with(Status::Usage, error.what());
  } catch (const SceneError& error) {
    return exit_with(Status::BadScene, error.what());
  } catch (const Error& error) {  // by what a scene says that its reader let through
    return exit_with(Status::BadScene, error.what());
  } catch (const Failure& failure) {
    return exit_with(failure);
  } catch (const Interrupted&) {
    return exit_with(interruption("atoll", "between two steps"));
  } catch (const std::bad_alloc&) {
    return exit_with(Status::BadScene, "the scene needs more memory than there is");
  } catch (const std::exception& error) {
    return exit_with(Status::CheckFailed, std::string("internal error: ") + error.what());
  }
}

}  // namespace atl::command
