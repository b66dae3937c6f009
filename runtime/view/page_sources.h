#pragma once

namespace atl::view::page {

/// The files of page/, as they were built in; the script is one of all modules, and empty in a build without the page.
extern const char* const index;
extern const char* const style;
extern const char* const script;
extern const char* const script_sha256;  ///< in hexadecimal

}  // namespace atl::view::page
