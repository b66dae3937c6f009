#include "view/film_page.h"

#include <ostream>
#include <string>
#include <string_view>

#include "view/film.h"
#include "view/page_sources.h"

namespace atl::view {
namespace {

// JSON that may stand in a script element: nothing in it ends the element or starts a comment.
void write_inert(std::ostream& out, std::string_view json) {
  for (std::size_t at = json.find('<'); at != std::string_view::npos; at = json.find('<')) {
    out << json.substr(0, at) << "\\u003c";
    json.remove_prefix(at + 1);
  }
  out << json;
}

}  // namespace

bool has_page() { return !std::string_view(page::script).empty(); }

void write_page(std::ostream& out, Film& film) {
  std::string_view rest = page::index;
  const auto write_to = [&](std::string_view mark) {
    const std::size_t at = rest.find(mark);
    out << rest.substr(0, at);
    rest.remove_prefix(at + mark.size());
  };
  write_to("/* style.css */");
  out << page::style;
  write_to("/* film.json */");
  write_inert(out, film.text());
  write_to("/* page.js */");
  out << page::script;
  out << rest;
}

}  // namespace atl::view
