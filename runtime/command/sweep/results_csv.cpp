#include <ostream>

#include "checks/tradeoff/table.h"
#include "results.h"

namespace atl::command {
namespace {

// RFC 4180.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

void write_results_csv(std::ostream& out, const SweepResults& results) {
  const tradeoff::Table table = tradeoff::table_of(results.scenes);
  const char* comma = "";
  for (const tradeoff::Table::Column& column : table.columns) {
    out << comma << cell(column.name);
    comma = ",";
  }
  out << '\n';
  for (const std::vector<std::string>& row : table.rows) {
    comma = "";
    for (const std::string& text : row) {
      out << comma << cell(text);
      comma = ",";
    }
    out << '\n';
  }
}

}  // namespace atl::command
