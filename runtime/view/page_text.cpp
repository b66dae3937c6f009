#include "view/page_text.h"

#include <charconv>
#include <cstdint>
#include <ostream>
#include <vector>

#include "view/packed.h"

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

std::string hash_source(std::string_view sha256) {
  std::vector<std::uint8_t> bytes(sha256.size() / 2);
  for (std::size_t i = 0; i < bytes.size(); ++i) std::from_chars(&sha256[2 * i], &sha256[2 * i] + 2, bytes[i], 16);
  return "'sha256-" + base64(bytes) + "'";
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
