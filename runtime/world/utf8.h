#pragma once

#include <cstddef>
#include <string_view>

namespace atl {

/// True if a text is well-formed UTF-8 (RFC 3629): no longer forms than needed, no surrogates, nothing above U+10FFFF.
inline bool is_utf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char first = byte(at++);
    if (first < 0x80) continue;
    const int more = first >= 0xf0 ? 3 : first >= 0xe0 ? 2 : 1;
    if (first < 0xc2 || first > 0xf4) return false;
    // The second byte rules out longer forms, surrogates and what is too large.
    unsigned char lower = 0x80, upper = 0xbf;
    if (first == 0xe0) lower = 0xa0;
    if (first == 0xed) upper = 0x9f;
    if (first == 0xf0) lower = 0x90;
    if (first == 0xf4) upper = 0x8f;
    for (int i = 0; i < more; ++i, lower = 0x80, upper = 0xbf) {
      if (at == text.size() || byte(at) < lower || byte(at) > upper) return false;
      ++at;
    }
  }
  return true;
}

/// True if a text is UTF-8 without control characters (U+0000 to U+001F and U+007F to U+009F), with which it could move
/// a terminal's cursor.
inline bool is_name(std::string_view text) {
  if (!is_utf8(text)) return false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const auto byte = static_cast<unsigned char>(text[at]);
    if (byte < 0x20 || byte == 0x7f) return false;
    if (byte == 0xc2 && static_cast<unsigned char>(text[at + 1]) < 0xa0) return false;
  }
  return true;
}

}  // namespace atl
