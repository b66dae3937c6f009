#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <ostream>

#include "names.h"
#include "soak_report.h"

namespace atl::command {
namespace {

constexpr double min_ms = 1e-4;
constexpr double megabyte = 1e6;

std::string drift_words(const std::optional<double>& drift) { return drift ? fixed(100 * *drift, 2) : "warm-up"; }

std::size_t bytes_of(const World& world) {
  std::size_t all = 0;
  for (const MemoryUse& use : world.memory()) all += use.bytes;
  return all;
}

struct Column {
  const char* title;
  int width;
};
constexpr Column columns[] = {{"s", 7},       {"steps", 10},     {"bodies", 7}, {"joints", 7}, {"RSS MB", 9},
                              {"drift %", 8}, {"world MB", 9},   {"p50 ms", 8}, {"p99", 8},    {"p99.9", 8},
                              {"max", 8},     {"p99.9/p50", 10}, {"lost", 5},   {"hashes", 8}};

}  // namespace

void TimeClasses::add(double ms) {
  const double place = std::log(std::max(ms, min_ms) / min_ms) / std::log(1.01);
  ++counts_[std::min(static_cast<std::size_t>(place), classes - 1)];
  ++count_;
  max_ = std::max(max_, ms);
}

void TimeClasses::add(const TimeClasses& other) {
  for (std::size_t i = 0; i < classes; ++i) counts_[i] += other.counts_[i];
  count_ += other.count_;
  max_ = std::max(max_, other.max_);
}

double TimeClasses::quantile(double share) const {
  if (count_ == 0) return 0;
  const auto rank = static_cast<std::int64_t>(std::ceil(share * static_cast<double>(count_)));
  std::int64_t below = 0;
  for (std::size_t i = 0; i < classes; ++i) {
    below += counts_[i];
    if (below >= rank) return std::min(max_, min_ms * std::pow(1.01, static_cast<double>(i) + 0.5));
  }
  return max_;
}

std::size_t resident_memory() {
  std::ifstream statm("/proc/self/statm");
  std::size_t pages = 0, resident = 0;
  statm >> pages >> resident;
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

std::size_t MemoryDrift::min() const {
  return *std::min_element(last_.begin(), last_.begin() + static_cast<std::ptrdiff_t>(std::min(new_, samples)));
}

void MemoryDrift::note(std::int64_t step, std::size_t bytes) {
  last_[new_++ % samples] = bytes;
  if (step < next_mark_) return;
  at_mark_before_ = at_mark_;
  at_mark_ = min();
  next_mark_ *= 2;
}

std::optional<double> MemoryDrift::drift() const {
  if (at_mark_before_ == 0) return std::nullopt;
  return static_cast<double>(min()) / static_cast<double>(at_mark_before_) - 1;
}

void write_soak_head(std::ostream& out) {
  for (const Column& column : columns) out << std::right << std::setw(column.width) << column.title;
  out << "\n";
}

void write_soak_line(std::ostream& out, double seconds, const soak::Soak& soak, const TimeClasses& times,
                     const std::optional<double>& drift) {
  const soak::SoakTally& tally = soak.tally();
  const double median = times.quantile(0.5), rare = times.quantile(0.999);
  const std::string cells[] = {fixed(seconds, 0),
                               std::to_string(tally.steps),
                               std::to_string(soak.world().body_count()),
                               std::to_string(soak.world().joint_count()),
                               fixed(static_cast<double>(resident_memory()) / megabyte, 1),
                               drift_words(drift),
                               fixed(static_cast<double>(bytes_of(soak.world())) / megabyte, 2),
                               significant(median, 3),
                               significant(times.quantile(0.99), 3),
                               significant(rare, 3),
                               significant(times.max(), 3),
                               median > 0 ? fixed(rare / median, 1) : "",
                               std::to_string(tally.quarantined + tally.fell_through),
                               std::to_string(tally.hash_checks)};
  for (std::size_t i = 0; i < std::size(cells); ++i) out << std::right << std::setw(columns[i].width) << cells[i];
  out << std::endl;
}

void write_soak_end(std::ostream& out, const soak::SoakTally& tally, const TimeClasses& all,
                    const std::optional<double>& drift) {
  out << "\nsteps     " << tally.steps << "; p50 " << significant(all.quantile(0.5), 3) << " ms, p99 "
      << significant(all.quantile(0.99), 3) << ", p99.9 " << significant(all.quantile(0.999), 3) << ", max "
      << significant(all.max(), 3) << "\n"
      << "came      " << tally.came << " things, " << tally.went << " went, " << tally.tied << " ropes were tied, "
      << plural(tally.broke, "joint") << " broke, " << plural(tally.changes, "other change") << "\n"
      << "checked   " << tally.hash_checks << " hashes, " << plural(tally.rollbacks, "rollback") << ", "
      << plural(tally.replays, "recording") << ", " << plural(tally.queries, "query", "queries") << "\n"
      << "memory    " << (drift ? fixed(100 * *drift, 2) + "% more than after warm-up" : "no longer than warm-up")
      << "\n"
      << "fastest   " << significant(tally.fastest, 4) << " m/s\n"
      << "lost      " << plural(tally.quarantined, "body", "bodies") << " in quarantine, " << tally.fell_through
      << " through the ground\n";
  for (const soak::LostBody& lost : tally.lost) {
    out << "  step " << lost.step << ", body " << lost.id.index << " of a " << lost.thing << ": " << lost.why
        << ", with " << lost.settings << " (" << lost.recording << ", step " << lost.recorded_step << ")\n";
  }
}

}  // namespace atl::command
