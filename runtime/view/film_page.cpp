#include "view/film_page.h"

#include <string_view>

#include "view/film.h"
#include "view/packed.h"
#include "view/page_sources.h"
#include "view/page_text.h"

namespace atl::view {
bool has_page() { return !std::string_view(page::script).empty(); }

void write_page(std::ostream& out, Film& film) {
  write_filled(out, page::index,
               {{"/* hash */", hash_source(page::script_sha256)},
                {"/* style.css */", page::style},
                {"/* film.json */", inert(film.text())},
                {"/* page.js */", page::script}});
}

std::string framed(const std::string& page, int height) {
  Packer packer;
  packer.add(page.data(), page.size());
  return "<iframe sandbox=\"allow-scripts\" width=\"100%\" height=\"" + std::to_string(height) +
         "\" style=\"border: 0\" srcdoc=\"<!DOCTYPE html><script>(async () => {"
         "const bytes = Uint8Array.from(atob('" +
         packer.text() +
         "'), (c) => c.charCodeAt(0));"
         "const page = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));"
         "document.open(); document.write(await new Response(page).text()); document.close();"
         "})()</script>\"></iframe>";
}

}  // namespace atl::view
