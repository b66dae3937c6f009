#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace atl::view {

/// A file of VTKHDF 1.0 of the type UnstructuredGrid, made in memory by HDF5: the same bytes from the same data.
class VtkFile {
 public:
  /// Throws Error where HDF5 fails.
  VtkFile();
  ~VtkFile();
  VtkFile(const VtkFile&) = delete;
  VtkFile& operator=(const VtkFile&) = delete;

  /// Writes a data set within the group VTKHDF, of rows of so many numbers: float, double or an integer.
  template <typename Number>
  void write(const char* name, const std::vector<Number>& values, std::size_t columns = 1);
  std::vector<char> bytes();

 private:
  using Id = std::int64_t;  // hid_t

  Id file_ = -1, group_ = -1;
};

}  // namespace atl::view
