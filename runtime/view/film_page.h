#pragma once

#include <iosfwd>
#include <string>

namespace atl::view {

class Film;

/// True if the page was built in: ATOLL_BUILD_PAGE.
bool has_page();

/// A page that plays the film, whole in itself: it loads nothing. Ends the film. Needs has_page().
void write_page(std::ostream& out, Film& film);

/// A page as an element of another one, such as a notebook: a frame of so many pixels' height that has the page in it,
/// deflated, and can neither see nor change what is around it.
std::string framed(const std::string& page, int height);

}  // namespace atl::view
