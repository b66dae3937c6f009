#pragma once

#include <iosfwd>

namespace atl::view {

class Film;

/// Whether the page was built in: ATOLL_BUILD_PAGE.
bool has_page();

/// A page that plays the film, whole in itself: it loads nothing. Ends the film. Needs has_page().
void write_page(std::ostream& out, Film& film);

}  // namespace atl::view
