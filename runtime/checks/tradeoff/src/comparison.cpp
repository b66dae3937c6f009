#include "checks/tradeoff/comparison.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

namespace atl::tradeoff {
namespace {

constexpr const char* atoll = "Atoll";

// Records that have both figures, by one measure.
class Field {
 public:
  Field(const std::vector<Record>& records, const std::string& measure) : records_(records), measure_(measure) {
    for (std::size_t i = 0; i < records.size(); ++i) {
      if (records[i].comparable() && records[i].error(measure)) places_.push_back(i);
    }
    const auto by_time = [this](std::size_t a, std::size_t b) {
      return time(a) != time(b) ? time(a) < time(b) : error(a) < error(b);
    };
    std::stable_sort(places_.begin(), places_.end(), by_time);
  }

  const std::vector<std::size_t>& by_time() const { return places_; }
  bool holds(std::size_t i) const { return std::find(places_.begin(), places_.end(), i) != places_.end(); }
  const Record& record(std::size_t i) const { return records_[i]; }
  bool is_atoll(std::size_t i) const { return records_[i].engine == atoll; }
  double time(std::size_t i) const { return records_[i].cpu.median(); }
  double error(std::size_t i) const { return std::max(no_error, *records_[i].error(measure_)); }

  /// The first that `eligible` holds for at no more error than `bound`, in order of time.
  std::optional<std::size_t> fastest(double bound, const auto& eligible) const {
    for (const std::size_t i : places_) {
      if (error(i) <= bound && eligible(i)) return i;
    }
    return std::nullopt;
  }

  std::vector<std::size_t> front(bool of_atoll) const {
    std::vector<std::size_t> front;
    for (const std::size_t i : places_) {
      if (is_atoll(i) == of_atoll && (front.empty() || error(i) < error(front.back()))) front.push_back(i);
    }
    return front;
  }

 private:
  const std::vector<Record>& records_;
  std::string measure_;
  std::vector<std::size_t> places_;
};

std::string figure(double value) {
  std::ostringstream text;
  text << std::setprecision(value >= 10 && value < 1000 ? 3 : 2) << value;
  return text.str();
}

std::string error_text(double value) { return value <= no_error ? "none" : figure(value); }

std::string name(const Field& field, std::size_t i) {
  return field.record(i).engine + " (" + field.record(i).label + ")";
}

// Text about the nearest other engine, for use when no other is both faster and at no more error.
std::string nearest_other(const Field& field, std::size_t own, std::optional<std::size_t>& rival) {
  const auto others = [&](std::size_t i) { return !field.is_atoll(i); };
  if ((rival = field.fastest(field.error(own), others))) {
    return "; the fastest other at no more error, " + name(field, *rival) + ", takes " +
           figure(field.time(*rival) / field.time(own)) + " times as long";
  }
  for (const std::size_t i : field.by_time()) {
    if (others(i) && (!rival || field.error(i) < field.error(*rival))) rival = i;
  }
  if (!rival) return "";
  const std::string more = field.error(own) <= no_error
                               ? error_text(field.error(*rival)) + " where Atoll has none"
                               : figure(field.error(*rival) / field.error(own)) + " times that of Atoll's default";
  return "; none reaches its error: the least of the others, by " + name(field, *rival) + ", is " + more;
}

Verdict beaten(const Field& field, std::size_t own, std::size_t rival) {
  std::string text = name(field, rival) + " is faster than Atoll's default at no more error: " +
                     figure(field.time(own) / field.time(rival)) + " times as fast, error " +
                     error_text(field.error(rival)) + " against " + error_text(field.error(own));
  if (field.record(rival).cpu.max() > field.record(own).cpu.min()) text += " (their ranges of times overlap)";
  const auto atolls = [&](std::size_t i) { return field.is_atoll(i); };
  const auto answer = field.fastest(field.error(rival), atolls);
  if (!answer) return {Verdict::Kind::Beaten, text + "; no setting of Atoll reaches that error.", rival};
  const double ratio = field.time(*answer) / field.time(rival);
  text += "; at that error, Atoll's fastest setting (" + field.record(*answer).label + ") ";
  text += ratio > 1 ? "takes " + figure(ratio) + " times as long." : "is " + figure(1 / ratio) + " times as fast.";
  return {Verdict::Kind::Beaten, text, rival};
}

// Reasons of all other engines that have no figures here.
std::string reasons(const std::vector<Record>& records, const Field& field) {
  std::string text;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const Record& record = records[i];
    if (record.engine == atoll || !record.is_default || field.holds(i)) continue;
    text += (text.empty() ? " " : "; ") + record.engine + ": " +
            (record.outcome == Outcome::Done ? "does not tell this measure" : record.why);
  }
  return text.empty() ? text : text + ".";
}

// Text about runs of other engines that were skipped or cut off, and might have changed the result.
std::string untried(const std::vector<Record>& records) {
  const auto cut = [](const Record& record) {
    return record.outcome == Outcome::Skipped || record.outcome == Outcome::TooSlow;
  };
  const auto count = std::count_if(records.begin(), records.end(), cut);
  if (count == 0) return "";
  return " (" + std::to_string(count) + " of the other engines' settings were stopped or not tried, for their time.)";
}

// The fastest runs on each side, where the default's own ended badly.
std::string survivors(const Field& field) {
  std::string text;
  for (const bool of_atoll : {true, false}) {
    const auto on_side = [&](std::size_t i) { return field.is_atoll(i) == of_atoll; };
    const auto first = std::find_if(field.by_time().begin(), field.by_time().end(), on_side);
    if (first == field.by_time().end()) {
      text += of_atoll ? " No setting of Atoll ended well." : "";
    } else {
      text += std::string(" The fastest that ended well ") + (of_atoll ? "of Atoll's settings" : "of all others") +
              ": " + name(field, *first) + ", error " + error_text(field.error(*first)) + ", " +
              figure(field.time(*first)) + " s a simulated second.";
    }
  }
  return text;
}

Verdict judge(const std::vector<Record>& records, const Field& field) {
  const auto is_own = [](const Record& record) { return record.engine == atoll && record.is_default; };
  const auto found = std::find_if(records.begin(), records.end(), is_own);
  const auto own = static_cast<std::size_t>(found - records.begin());
  if (found == records.end()) return {Verdict::Kind::NoStanding, "Atoll's default was not run.", {}};
  if (!field.holds(own)) {
    const std::string why = found->why.empty() ? "has no figure by this measure" : found->why;
    return {Verdict::Kind::NoStanding, "Atoll's default " + why + "." + survivors(field), {}};
  }
  const auto is_other = [&](std::size_t i) { return !field.is_atoll(i); };
  if (std::none_of(field.by_time().begin(), field.by_time().end(), is_other)) {
    return {Verdict::Kind::Alone, "No other engine to compare with." + reasons(records, field), {}};
  }
  const auto rival =
      field.fastest(field.error(own), [&](std::size_t i) { return is_other(i) && field.time(i) < field.time(own); });
  if (rival) return beaten(field, own, *rival);

  Verdict verdict = {
      Verdict::Kind::OnFront,
      "Atoll's default is on the front: no setting of another engine is both faster and at no more error",
      {}};
  verdict.text += nearest_other(field, own, verdict.rival) + "." + untried(records);
  return verdict;
}

}  // namespace

const char* name_of(Verdict::Kind kind) {
  switch (kind) {
    case Verdict::Kind::OnFront:
      return "on_front";
    case Verdict::Kind::Beaten:
      return "beaten";
    case Verdict::Kind::Alone:
      return "alone";
    case Verdict::Kind::NotJudged:
      return "not_judged";
    case Verdict::Kind::NoStanding:
      break;
  }
  return "no_standing";
}

Comparison compare(const std::vector<Record>& records, const std::string& measure) {
  const Field field(records, measure);
  Comparison comparison = {.measure = measure,
                           .atoll_front = field.front(true),
                           .peer_front = field.front(false),
                           .matches = std::vector<std::optional<Match>>(records.size()),
                           .verdict = judge(records, field)};
  for (const std::size_t i : field.by_time()) {
    const auto other = [&](std::size_t j) { return records[j].engine != records[i].engine; };
    if (const auto match = field.fastest(field.error(i), other)) {
      comparison.matches[i] = Match{*match, field.time(*match) / field.time(i)};
    }
  }
  return comparison;
}

}  // namespace atl::tradeoff
