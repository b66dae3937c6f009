#pragma once
/// How Python hands over vectors, quaternions and matrices: as any sequence of numbers, and back as arrays that can't
/// be written to, as they are copies.

#include <atoll/types.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cstddef>

namespace atl::python {

namespace nb = nanobind;

/// Fills `numbers` from a sequence of exactly so many. False, and no exception set, if that is not one.
inline bool read_numbers(PyObject* from, double* numbers, Py_ssize_t count) noexcept {
  PyObject* items = PyUnicode_Check(from) ? nullptr : PySequence_Fast(from, "");
  bool fits = items != nullptr && PySequence_Fast_GET_SIZE(items) == count;
  for (Py_ssize_t i = 0; fits && i < count; ++i) {
    numbers[i] = PyFloat_AsDouble(PySequence_Fast_GET_ITEM(items, i));
    fits = PyErr_Occurred() == nullptr;
  }
  Py_XDECREF(items);
  PyErr_Clear();
  return fits;
}

/// An array of its own of numbers in rows.
template <typename T, std::size_t dimensions>
nb::handle array_of(const T* numbers, const std::size_t (&shape)[dimensions]) noexcept {
  std::size_t count = 1;
  for (const std::size_t length : shape) count *= length;
  auto* copy = new T[count];
  std::copy_n(numbers, count, copy);
  try {
    const nb::capsule owner(copy, [](void* memory) noexcept { delete[] static_cast<T*>(memory); });
    return nb::ndarray<nb::numpy, const T>(copy, dimensions, shape, owner).cast().release();
  } catch (nb::python_error& error) {
    error.restore();
    return {};
  }
}

}  // namespace atl::python

namespace nanobind::detail {

#define ATOLL_ARRAY_IN "collections.abc.Sequence[float] | numpy.typing.NDArray[numpy.float64]"
#define ATOLL_ARRAY_OUT "numpy.typing.NDArray[numpy.float64]"

template <>
struct type_caster<atl::Vector3> {
  NB_TYPE_CASTER(atl::Vector3, io_name(ATOLL_ARRAY_IN, ATOLL_ARRAY_OUT))

  bool from_python(handle src, std::uint8_t, cleanup_list*) noexcept {
    return atl::python::read_numbers(src.ptr(), value.data(), 3);
  }
  static handle from_cpp(const atl::Vector3& from, rv_policy, cleanup_list*) noexcept {
    return atl::python::array_of(from.data(), {3});
  }
};

/// x, y, z, w, as in all arrays of orientations.
template <>
struct type_caster<atl::Quaternion> {
  NB_TYPE_CASTER(atl::Quaternion, io_name(ATOLL_ARRAY_IN, ATOLL_ARRAY_OUT))

  bool from_python(handle src, std::uint8_t, cleanup_list*) noexcept {
    return atl::python::read_numbers(src.ptr(), value.coeffs().data(), 4);
  }
  static handle from_cpp(const atl::Quaternion& from, rv_policy, cleanup_list*) noexcept {
    return atl::python::array_of(from.coeffs().data(), {4});
  }
};

template <>
struct type_caster<atl::Matrix3> {
  NB_TYPE_CASTER(atl::Matrix3, io_name("collections.abc.Sequence[collections.abc.Sequence[float]] | " ATOLL_ARRAY_OUT,
                                       ATOLL_ARRAY_OUT))

  bool from_python(handle src, std::uint8_t, cleanup_list*) noexcept {
    PyObject* rows = PySequence_Fast(src.ptr(), "");
    bool fits = rows != nullptr && PySequence_Fast_GET_SIZE(rows) == 3;
    for (Py_ssize_t row = 0; fits && row < 3; ++row) {
      double numbers[3] = {};
      fits = atl::python::read_numbers(PySequence_Fast_GET_ITEM(rows, row), numbers, 3);
      for (Eigen::Index i = 0; i < 3; ++i) value(row, i) = numbers[i];
    }
    Py_XDECREF(rows);
    PyErr_Clear();
    return fits;
  }
  static handle from_cpp(const atl::Matrix3& from, rv_policy, cleanup_list*) noexcept {
    const atl::Matrix3 by_row = from.transpose();
    return atl::python::array_of(by_row.data(), {3, 3});
  }
};

#undef ATOLL_ARRAY_IN
#undef ATOLL_ARRAY_OUT

}  // namespace nanobind::detail
