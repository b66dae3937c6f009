#include "view/film_page.h"

#include <string_view>

#include "view/film.h"
#include "view/page_sources.h"
#include "view/page_text.h"

namespace atl::view {
bool has_page() { return !std::string_view(page::script).empty(); }

void write_page(std::ostream& out, Film& film) {
  write_filled(
      out, page::index,
      {{"/* style.css */", page::style}, {"/* film.json */", inert(film.text())}, {"/* page.js */", page::script}});
}

}  // namespace atl::view
