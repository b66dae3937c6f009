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

}  // namespace atl
