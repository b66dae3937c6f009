#pragma once
/// How Python hands over vectors, quaternions and matrices: as any sequence of numbers, and back as arrays that can't
/// be written to, as they are copies. Enums are taken by name, too.

#include <atoll/types.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <type_traits>

namespace atl::python {

namespace nb = nanobind;

/// Why an argument of the call under way was refused, where more can be said than its type.
inline std::string& refusal() {
  thread_local std::string words;
  return words;
}

/// The member of an enum that a text names, in any case and with '-' for '_'; None, and a refusal, if none has the
/// name.
inline nb::object member_named(nb::handle type, nb::handle text) {
  const nb::object members = type.attr("__members__");
  nb::object found = members.attr("get")(text.attr("upper")().attr("replace")("-", "_"));
  if (found.is_none()) {
    const nb::object known = nb::str(", ").attr("join")(members).attr("lower")();
    refusal() = nb::cast<std::string>(
        nb::str("found {!r} for {}; expected of {}").attr("format")(text, type.attr("__name__"), known));
  }
  return found;
}

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

template <typename Enum>
requires std::is_enum_v<Enum>
struct type_caster<Enum, enable_if_t<std::is_enum_v<Enum>>> {
  NB_TYPE_CASTER(Enum, const_name<Enum>() + const_name("@ | str@@"))

  bool from_python(handle src, std::uint32_t flags, cleanup_list* cleanup) noexcept {
    object member = borrow(src);
    if (PyUnicode_Check(src.ptr())) {
      try {
        member = atl::python::member_named(nanobind::type<Enum>(), src);
      } catch (python_error&) {
        return false;
      }
    }
    std::int64_t number = 0;
    const bool fits = NB_CALL(enum_from_python)(NB_CTX_C(cleanup), &typeid(Enum), member.ptr(), &number, flags);
    if (fits) value = static_cast<Enum>(number);
    return fits;
  }
  static handle from_cpp(Enum from, rv_policy, cleanup_list* cleanup) noexcept {
    return NB_CALL(enum_from_cpp)(NB_CTX_C(cleanup), &typeid(Enum), static_cast<std::int64_t>(from));
  }
};

}  // namespace nanobind::detail
