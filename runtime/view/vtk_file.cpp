#include "view/vtk_file.h"

#include <atoll/error.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <type_traits>
#include <utility>

namespace atl::view {
namespace {

// Calls fail by negative numbers.
hid_t checked(hid_t id, const char* what) {
  if (id < 0) throw Error(std::string("the VTKHDF file could not be made: HDF5 failed to ") + what);
  return id;
}

// Owns a handle of HDF5, and closes it.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t), const char* what) : id_(checked(id, what)), close_(close) {}
  ~Handle() { close_(id_); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

template <typename Number>
hid_t stored_type() {
  if constexpr (std::is_same_v<Number, float>) return H5T_IEEE_F32LE;
  if constexpr (std::is_same_v<Number, double>) return H5T_IEEE_F64LE;
  if constexpr (std::is_same_v<Number, std::int8_t>) return H5T_STD_I8LE;
  if constexpr (std::is_same_v<Number, std::uint8_t>) return H5T_STD_U8LE;
  if constexpr (std::is_same_v<Number, std::int32_t>) return H5T_STD_I32LE;
  if constexpr (std::is_same_v<Number, std::int64_t>) return H5T_STD_I64LE;
}

void write_attribute(hid_t group, const char* name, hid_t type, hid_t space, const void* value) {
  const Handle attribute(H5Acreate2(group, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose, "add an attribute");
  checked(H5Awrite(attribute, type, value), "write an attribute");
}

}  // namespace

VtkFile::VtkFile() {
  static_assert(std::is_same_v<Id, hid_t>);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // else it prints
  constexpr std::size_t grows_by = std::size_t{1} << 20;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "begin a file");
  checked(H5Pset_fapl_core(access, grows_by, false), "keep a file in memory");
  file_ = checked(H5Fcreate("atoll.vtkhdf", H5F_ACC_TRUNC, H5P_DEFAULT, access), "begin a file");
  const Handle untimed(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, "add a group");
  checked(H5Pset_obj_track_times(untimed, false), "add a group");
  group_ = checked(H5Gcreate2(file_, "VTKHDF", H5P_DEFAULT, untimed, H5P_DEFAULT), "add a group");
  for (const char* name : {"PointData", "CellData", "FieldData"}) {
    const Handle group(H5Gcreate2(group_, name, H5P_DEFAULT, untimed, H5P_DEFAULT), H5Gclose, "add a group");
  }
  const std::array<std::int64_t, 2> version = {1, 0};
  const hsize_t two = 2;
  const Handle pair(H5Screate_simple(1, &two, nullptr), H5Sclose, "add an attribute");
  write_attribute(group_, "Version", H5T_NATIVE_INT64, pair, version.data());
  constexpr char type[] = "UnstructuredGrid";
  const Handle one(H5Screate(H5S_SCALAR), H5Sclose, "add an attribute");
  const Handle text(H5Tcopy(H5T_C_S1), H5Tclose, "add an attribute");
  checked(H5Tset_size(text, sizeof type - 1), "add an attribute");
  checked(H5Tset_strpad(text, H5T_STR_NULLPAD), "add an attribute");
  write_attribute(group_, "Type", text, one, type);
}

VtkFile::~VtkFile() {
  H5Gclose(group_);
  H5Fclose(file_);
}

template <typename Number>
void VtkFile::write(const char* name, const std::vector<Number>& values, std::size_t columns) {
  const std::array<hsize_t, 2> size = {values.size() / columns, columns};
  const int rank = columns == 1 ? 1 : 2;
  const Handle space(H5Screate_simple(rank, size.data(), nullptr), H5Sclose, "add a data set");
  const Handle how(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "add a data set");
  checked(H5Pset_obj_track_times(how, false), "add a data set");
  constexpr hsize_t rows_of_chunk = 1 << 16;
  if (size[0] > 1000) {
    const std::array<hsize_t, 2> chunk = {std::min(size[0], rows_of_chunk), columns};
    checked(H5Pset_chunk(how, rank, chunk.data()), "add a data set");
    checked(H5Pset_shuffle(how), "add a data set");
    checked(H5Pset_deflate(how, 1), "add a data set");
  }
  const hid_t type = stored_type<Number>();
  const Handle set(H5Dcreate2(group_, name, type, space, H5P_DEFAULT, how, H5P_DEFAULT), H5Dclose, "add a data set");
  checked(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "write a data set");
}

template void VtkFile::write(const char*, const std::vector<float>&, std::size_t);
template void VtkFile::write(const char*, const std::vector<double>&, std::size_t);
template void VtkFile::write(const char*, const std::vector<std::int8_t>&, std::size_t);
template void VtkFile::write(const char*, const std::vector<std::uint8_t>&, std::size_t);
template void VtkFile::write(const char*, const std::vector<std::int32_t>&, std::size_t);
template void VtkFile::write(const char*, const std::vector<std::int64_t>&, std::size_t);

std::vector<char> VtkFile::bytes() {
  checked(H5Fflush(file_, H5F_SCOPE_GLOBAL), "end a file");
  std::vector<char> bytes(static_cast<std::size_t>(checked(H5Fget_file_image(file_, nullptr, 0), "end a file")));
  checked(H5Fget_file_image(file_, bytes.data(), bytes.size()), "end a file");
  return bytes;
}

}  // namespace atl::view
