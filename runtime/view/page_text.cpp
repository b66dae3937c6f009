#include "view/page_text.h"

#include <ostream>

namespace atl::view {

std::string inert(std::string_view json) {
  std::string text;
  text.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      text += "\\u003c";
    } else {
      text += c;
    }
  }
  return text;
}

void write_filled(std::ostream& out, std::string_view page, std::initializer_list<PagePart> parts) {
  for (const PagePart& part : parts) {
    const std::size_t at = page.find(part.mark);
    out << page.substr(0, at) << part.content;
    page.remove_prefix(at + part.mark.size());
  }
  out << page;
}

}  // namespace atl::view
