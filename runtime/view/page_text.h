#pragma once

#include <initializer_list>
#include <iosfwd>
#include <string>
#include <string_view>

namespace atl::view {

/// JSON that may stand in a script element: nothing in it ends the element or starts a comment.
std::string inert(std::string_view json);

/// The source of Content Security Policy (W3C, level 3, 2.3.1) that is this script alone: its SHA-256, in hexadecimal.
std::string hash_source(std::string_view sha256);

struct PagePart {
  std::string_view mark;  ///< where it goes
  std::string_view content;
};

/// A page with its parts in place of their marks, which stand in it in that order.
void write_filled(std::ostream& out, std::string_view page, std::initializer_list<PagePart> parts);

}  // namespace atl::view
