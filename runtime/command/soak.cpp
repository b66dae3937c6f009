#include "soak.h"

#include <stdlib.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <limits>

#include "failure.h"
#include "interrupt.h"
#include "names.h"
#include "soak_report.h"
#include "standard_streams.h"

namespace atl::command {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// The folder of recordings. A temporary one is removed at the end unless recordings stay in it.
class RecordingFolder {
 public:
  explicit RecordingFolder(const std::string& path) : path_(path), own_(path.empty()) {
    std::error_code error;
    if (own_) {
      std::string name = (fs::temp_directory_path() / "atoll-soak-XXXXXX").string();
      if (::mkdtemp(name.data()) == nullptr) error = {errno, std::generic_category()};
      path_ = name;
    } else {
      fs::create_directories(path_, error);
    }
    if (error) {
      throw Failure(Status::Usage,
                    "--recordings: cannot make the directory " + path_.string() + ": " + error.message());
    }
  }
  ~RecordingFolder() {
    std::error_code not_empty;
    if (own_) fs::remove(path_, not_empty);
  }
  RecordingFolder(const RecordingFolder&) = delete;
  RecordingFolder& operator=(const RecordingFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
  bool own_;
};

double seconds_asked(const SoakCommandOptions& options) {
  if (!options.hours && !options.minutes && !options.steps) {
    throw Failure(Status::Usage,
                  "soak: found no length, expected --hours, --minutes or --steps (see atoll soak --help)");
  }
  constexpr double for_ever = std::numeric_limits<double>::infinity();
  return std::min(options.hours ? 3600 * *options.hours : for_ever, options.minutes ? 60 * *options.minutes : for_ever);
}

std::string world_words(const World& world) { return plural(world.threads(), "thread") + ", " + name_of(world.simd()); }

// Prints the progress of a soak.
class Diary {
 public:
  explicit Diary(double interval) : interval_(interval) {}

  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  void note(const soak::Soak& soak, const StepReport& report) {
    times_.add(report.ms);
    const std::int64_t steps = soak.tally().steps;
    if (steps % soak::segment_steps() == 0) memory_.note(steps, resident_memory());
    if (seconds() >= next_) write(soak);
  }
  void end(const soak::Soak& soak) {
    if (times_.count() > 0) write(soak);
    write_soak_end(std::cout, soak.tally(), all_, memory_.drift());
  }
  std::optional<double> drift() const { return memory_.drift(); }

 private:
  void write(const soak::Soak& soak) {
    write_soak_line(std::cout, seconds(), soak, times_, memory_.drift());
    finish_output();
    all_.add(times_);
    times_ = {};
    next_ = seconds() + interval_;
  }

  double interval_;
  Clock::time_point start_ = Clock::now();
  double next_ = interval_;
  TimeClasses times_;
  TimeClasses all_;
  MemoryDrift memory_;
};

}  // namespace

void soak(const SoakCommandOptions& options) {
  const double seconds = seconds_asked(options);
  const RecordingFolder folder(options.recordings);
  std::optional<soak::Soak> soak;
  try {
    soak.emplace(soak::SoakOptions{
        .threads = options.threads, .seed = options.seed, .folder = folder.path(), .stop = interrupted});
  } catch (const soak::RecordingFailed& failed) {
    throw Failure(Status::Usage, std::string("--recordings: ") + failed.what());
  } catch (const Error& error) {
    throw Failure(Status::Usage, error.what());
  }
  std::cout << "soak      seed " << options.seed << "; " << world_words(soak->world()) << "; beside it "
            << world_words(soak->second()) << "; recordings in " << folder.path().string() << "\n";
  write_soak_head(std::cout);
  Diary diary(options.interval);
  try {
    while (!interrupted() && diary.seconds() < seconds &&
           soak->tally().steps < options.steps.value_or(std::numeric_limits<int>::max())) {
      diary.note(*soak, soak->step());
    }
  } catch (const soak::RecordingFailed& failed) {
    diary.end(*soak);
    throw Failure(Status::Usage, std::string("--recordings: ") + failed.what());
  } catch (const soak::CheckFailed& failed) {
    diary.end(*soak);
    throw Failure(Status::CheckFailed, "soak: step " + std::to_string(soak->tally().steps) + ": " + failed.what());
  } catch (const Error& error) {
    diary.end(*soak);
    throw Failure(Status::CheckFailed,
                  "soak: ahead of step " + std::to_string(soak->tally().steps + 1) + ": " + error.what());
  }
  diary.end(*soak);
  finish_output();
  if (diary.drift().value_or(0) > MemoryDrift::max_growth) {
    throw Failure(Status::CheckFailed, "soak: memory grew by " + fixed(100 * *diary.drift(), 2) +
                                           "% after warm-up, expected at most " +
                                           fixed(100 * MemoryDrift::max_growth, 0) + "%");
  }
  if (interrupted()) throw interruption("soak", "after step " + std::to_string(soak->tally().steps));
}

}  // namespace atl::command
