#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "record.h"

namespace atl::tradeoff {

/// Errors below this count as none, and as equal.
inline constexpr double no_error = 1e-16;

/// How Atoll's default stands among the runs of other engines.
struct Verdict {
  enum class Kind {
    OnFront,     ///< no other engine has a setting that is both faster and at no more error
    Beaten,      ///< one has
    Alone,       ///< no other engine has anything to hold against it
    NoStanding,  ///< the default has no error or time itself
    NotJudged,   ///< nothing has happened yet that the measure would tell of
  };

  Kind kind = Kind::Alone;
  std::string text = {};                  ///< in words
  std::optional<std::size_t> rival = {};  ///< the record that the words are about
};

/// "on_front", "beaten", "alone", "no_standing", "not_judged".
const char* name_of(Verdict::Kind kind);

/// The fastest run of any other engine at no more error.
struct Match {
  std::size_t record = 0;
  double time_ratio = 1;  ///< its time over that of the run it is matched with
};

/// The runs of a scene by one measure of error. Numbers are places in the list of records.
struct Comparison {
  std::string measure = {};
  std::vector<std::size_t> atoll_front = {};       ///< runs that no other run of Atoll beats in both, by rising time
  std::vector<std::size_t> peer_front = {};        ///< likewise of all other engines
  std::vector<std::optional<Match>> matches = {};  ///< by record
  Verdict verdict = {};
};

Comparison compare(const std::vector<Record>& records, const std::string& measure);

}  // namespace atl::tradeoff
