#include <nlohmann/json.hpp>
#include <string>

#include "page_sources.h"
#include "results.h"
#include "results_object.h"
#include "view/page_text.h"

namespace atl::command {
using Json = nlohmann::ordered_json;

void write_results_page(std::ostream& out, const SweepResults& results, const std::string& date) {
  Json data = results_object(results);
  data["date"] = date;
  const std::string json = data.dump(-1, ' ', true, Json::error_handler_t::replace);
  view::write_filled(out, page::index,
                     {{"/* hash */", view::hash_source(page::script_sha256)},
                      {"/* style.css */", page::style},
                      {"/* results.json */", view::inert(json)},
                      {"/* page.js */", page::script}});
}

}  // namespace atl::command
