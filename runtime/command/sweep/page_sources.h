#pragma once

namespace atl::command::page {

/// The files of page/, as they were built in.
extern const char* const index;
extern const char* const style;
extern const char* const script;
extern const char* const script_sha256;  ///< in hexadecimal

}  // namespace atl::command::page
