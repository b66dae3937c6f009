#pragma once

#include <initializer_list>
#include <iosfwd>
#include <string>
#include <string_view>

namespace atl::view {

/// JSON that may stand in a script element: nothing in it ends the element or starts a comment.
std::string inert(std::string_view json);

struct PagePart {
  std::string_view mark;  ///< where it goes
  std::string_view content;
};

/// A page with its parts in place of their marks, which stand in it in that order.
void write_filled(std::ostream& out, std::string_view page, std::initializer_list<PagePart> parts);

}  // namespace atl::view
