#include "checks/tradeoff/peer_driver.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "checks/tradeoff/number_text.h"
#include "subprocess.h"

namespace atl::tradeoff {
namespace {

constexpr int refused_status = 3;
constexpr int non_finite_status = 4;

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

std::string seconds_text(double seconds) {
  std::ostringstream text;
  text << seconds << " s";
  return text.str();
}

void fail(Record& record, const std::string& why) {
  record.outcome = Outcome::Failed;
  record.why = why;
}

}  // namespace

PeerDriver::PeerDriver(std::string program, double limit, Stop stop)
    : program_(std::move(program)), limit_(limit), stop_(std::move(stop)) {
  const SubprocessResult result = run_subprocess({program_, "--describe"}, limit_, stop_);
  try {
    if (result.end != SubprocessResult::End::Exited || result.code != 0) throw std::runtime_error("no success");
    const nlohmann::json description = nlohmann::json::parse(result.out);
    engine_ = description.at("engine");
    version_ = description.at("version");
    precision_ = description.value("precision", "");
    for (const nlohmann::json& setting : description.at("settings")) {
      settings_.push_back({setting.at("label"), setting.at("options"), setting.value("large", false)});
    }
    if (settings_.empty()) throw std::runtime_error("no settings");
  } catch (const std::exception&) {
    const std::string said = first_line(result.err.empty() ? result.out : result.err);
    throw DriverError(program_ + " --describe: found " + (said.empty() ? "nothing" : "\"" + said + "\"") +
                      ", expected a JSON object with engine, version and settings");
  }
}

Record PeerDriver::describe(const PeerSetting& setting, const PeerRun& run) const {
  Record record = {.engine = engine_, .label = setting.label};
  std::string words;
  for (const std::string& option : setting.options) words += (words.empty() ? "" : " ") + option;
  record.options.emplace_back("options", words);
  record.is_default = &setting == &settings_.front();
  record.steps = run.steps;
  record.dt = run.dt;
  return record;
}

std::string PeerDriver::call(const PeerSetting& setting, const PeerRun& run, const std::vector<std::string>& what,
                             Record& record) const {
  std::vector<std::string> words = {program_, run.scene,     "--steps", std::to_string(run.steps),
                                    "--dt",   exact(run.dt), "--seed",  std::to_string(run.seed)};
  words.insert(words.end(), setting.options.begin(), setting.options.end());
  words.insert(words.end(), what.begin(), what.end());
  words.insert(words.end(), {"--format", "json"});
  const SubprocessResult result = run_subprocess(words, limit_, stop_);
  if (result.end == SubprocessResult::End::TimedOut) {
    record.outcome = Outcome::TooSlow;
    record.why = "took longer than " + seconds_text(limit_) + " and was stopped";
  } else if (result.end == SubprocessResult::End::Signalled) {
    fail(record, "the driver was ended by signal " + std::to_string(result.code));
  } else if (result.code == refused_status) {
    record.outcome = Outcome::Refused;
    record.why = first_line(result.err);
  } else if (result.code == non_finite_status) {
    record.outcome = Outcome::NonFinite;
    record.why = "became non-finite: " + first_line(result.err);
  } else if (result.code != 0) {
    fail(record, "the driver ended with status " + std::to_string(result.code) + ": " + first_line(result.err));
  }
  return result.out;
}

void PeerDriver::measure_errors(const PeerSetting& setting, const PeerRun& run, Record& record) const {
  const std::string out = call(setting, run, {"--errors"}, record);
  if (record.outcome != Outcome::Done) return;
  try {
    const nlohmann::ordered_json report = nlohmann::ordered_json::parse(out);
    for (const auto& [name, value] : report.at("errors").items()) record.errors.push_back({name, value, ""});
    if (report.value("fell", false)) {
      record.outcome = Outcome::Fell;
      record.why = "fell: a body left its place for good";
    }
    record.judge_joints();
  } catch (const std::exception&) {
    fail(record, "the driver's report of errors is not as expected: \"" + first_line(out) + "\"");
  }
}

void PeerDriver::measure_time(const PeerSetting& setting, const PeerRun& run, double min_time, Record& record) const {
  const Outcome before = record.outcome;
  record.outcome = Outcome::Done;
  const std::string out = call(setting, run, {"--time", exact(min_time)}, record);
  if (record.outcome != Outcome::Done) return;
  record.outcome = before;
  try {
    const nlohmann::json report = nlohmann::json::parse(out);
    const double cpu = report.at("cpu_s_per_simulated_s"), wall = report.at("ms_per_step").at("mean");
    record.cpu.add(cpu);
    record.wall.add(wall);
  } catch (const std::exception&) {
    fail(record, "the driver's report of times is not as expected: \"" + first_line(out) + "\"");
  }
}

std::vector<PeerDriver> ask_drivers(const std::vector<std::string>& programs, double limit, const Stop& stop) {
  std::vector<PeerDriver> drivers;
  for (const std::string& program : programs) {
    PeerDriver driver(program, limit, stop);
    const auto same = [&](const PeerDriver& other) { return other.engine() == driver.engine(); };
    if (driver.engine() == "Atoll" || std::any_of(drivers.begin(), drivers.end(), same)) {
      throw DriverError(program + ": found a second engine named \"" + driver.engine() + "\", expected each once");
    }
    drivers.push_back(std::move(driver));
  }
  return drivers;
}

}  // namespace atl::tradeoff
