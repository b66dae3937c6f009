#include <nlohmann/json.hpp>
#include <ostream>
#include <string_view>

#include "page_sources.h"
#include "results.h"
#include "results_object.h"

namespace atl::command {
namespace {

using Json = nlohmann::ordered_json;

// JSON that may stand in a script element: nothing in it ends the element or starts a comment.
std::string inert(const Json& object) {
  std::string text;
  for (const char c : object.dump(-1, ' ', true, Json::error_handler_t::replace)) {
    if (c == '<') {
      text += "\\u003c";
    } else {
      text += c;
    }
  }
  return text;
}

}  // namespace

void write_results_page(std::ostream& out, const SweepResults& results, const std::string& date) {
  Json data = results_object(results);
  data["date"] = date;
  struct Part {
    std::string_view mark;
    std::string content;
  };
  const Part parts[] = {
      {"/* style.css */", page::style}, {"/* results.json */", inert(data)}, {"/* page.js */", page::script}};
  std::string_view rest = page::index;
  for (const Part& part : parts) {
    const std::size_t at = rest.find(part.mark);
    out << rest.substr(0, at) << part.content;
    rest.remove_prefix(at + part.mark.size());
  }
  out << rest;
}

}  // namespace atl::command
