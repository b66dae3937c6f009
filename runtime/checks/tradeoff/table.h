#pragma once

#include <span>
#include <string>
#include <vector>

#include "scene_report.h"

namespace atl::tradeoff {

/// Results of runs, one row each, as in results.csv and in Python's tables.
struct Table {
  enum class Kind { Text, Flag, Integer, Number };  ///< what the texts of a column stand for; a flag is 1 or 0
  struct Column {
    std::string name;
    Kind kind;
  };
  std::vector<Column> columns;
  /// Numbers with all digits; "" where a run has none.
  std::vector<std::vector<std::string>> rows;
};

/// "text", "flag", "integer", "number".
const char* name_of(Table::Kind kind);

/// The table of all runs of all scenes, with a column for each axis and each measure of error that some run has.
Table table_of(std::span<const SceneReport> reports);

}  // namespace atl::tradeoff
