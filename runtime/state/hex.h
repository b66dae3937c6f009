#pragma once
/// Hashes and the like as messages and reports write them.

#include <cstdint>
#include <iomanip>
#include <sstream>
#include <string>

namespace atl {

/// "0x2a".
inline std::string hex(std::uint64_t value) {
  std::ostringstream out;
  out << "0x" << std::hex << value;
  return out.str();
}

/// "0x" and 16 hexadecimal digits.
inline std::string hash_text(std::uint64_t hash) {
  std::ostringstream out;
  out << "0x" << std::hex << std::setw(16) << std::setfill('0') << hash;
  return out.str();
}

}  // namespace atl
