#pragma once
/// Many bodies at once: arrays of a row each.

#include <atoll/types.h>
#include <atoll/world.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "casters.h"

namespace atl::python {

/// Numbers that are passed in: an array, or what numpy makes one of, as lists of lists. It is used as it is where type
/// and order fit, and copied else.
template <typename T, typename... Dimensions>
struct ArrayLike : nb::ndarray<const T, Dimensions..., nb::c_contig, nb::device::cpu> {};

template <int columns>
using Rows = ArrayLike<double, nb::shape<-1, columns>>;
using Numbers = ArrayLike<double, nb::ndim<1>>;
/// Rows of any number of columns.
using Heights = ArrayLike<double, nb::ndim<2>>;

/// An array of numpy's of what is passed in; none, and a refusal, where it makes none, or its numbers would be others.
inline nb::object numpy_array(nb::handle numbers, const char* type, bool whole) {
  const nb::module_ numpy = nb::module_::import_("numpy");
  const nb::object found = numpy.attr("asarray")(numbers);
  nb::object array = numpy.attr("asarray")(found, type, nb::arg("order") = "C");
  if (!whole || nb::cast<bool>(numpy.attr("array_equal")(found, array))) return array;
  refusal() = "found numbers that are no indices; expected whole ones from 0 on";
  return nb::none();
}

template <ssize_t... lengths>
std::string words_of(nb::shape<lengths...>) {
  std::string words;
  const char* free = "nmk";
  for (const ssize_t length : {lengths...}) {
    words += (words.empty() ? "(" : ", ") + (length < 0 ? std::string(1, *free++) : std::to_string(length));
  }
  return words + ")";
}

/// The rows as columns, without a copy.
template <int columns>
Eigen::Map<const Eigen::Matrix<double, columns, Eigen::Dynamic>> columns_of(const Rows<columns>& rows) {
  return {rows.data(), columns, static_cast<Eigen::Index>(rows.shape(0))};
}

/// A read-only array over memory of Atoll's, one row per body.
template <int columns>
using View = nb::ndarray<nb::numpy, const double, nb::shape<-1, columns>, nb::c_contig>;

/// A record of a structured array: the name and numpy's format of a member, and where it is.
struct Member {
  const char* name;
  const char* format;
  std::size_t offset;
};

/// The members of a contact's record.
inline const std::vector<Member>& contact_force_members() {
  static const std::vector<Member> members = {
      {"a", "id", offsetof(ContactForce, a)},
      {"b", "id", offsetof(ContactForce, b)},
      {"position", "(3,)f8", offsetof(ContactForce, position)},
      {"normal", "(3,)f8", offsetof(ContactForce, normal)},
      {"normal_force", "f8", offsetof(ContactForce, normal_force)},
      {"friction", "(3,)f8", offsetof(ContactForce, friction)},
      {"separation", "f8", offsetof(ContactForce, separation)},
      {"feature_id", "u8", offsetof(ContactForce, feature_id)},
      {"child_a", "u4", offsetof(ContactForce, child_a)},
      {"child_b", "u4", offsetof(ContactForce, child_b)},
  };
  return members;
}

/// numpy's type of records of so many bytes.
inline nb::object record_type(const std::vector<Member>& members, std::size_t bytes) {
  nb::list names, formats, offsets;
  for (const Member& member : members) {
    names.append(member.name);
    if (std::string(member.format) == "id") {
      nb::list id;
      id.append(nb::make_tuple("index", "u4"));
      id.append(nb::make_tuple("generation", "u4"));
      formats.append(nb::module_::import_("numpy").attr("dtype")(id));
    } else {
      formats.append(member.format);
    }
    offsets.append(member.offset);
  }
  nb::dict description;
  description["names"] = names;
  description["formats"] = formats;
  description["offsets"] = offsets;
  description["itemsize"] = bytes;
  return nb::module_::import_("numpy").attr("dtype")(description);
}

/// A structured array of copies.
template <typename Record>
nb::object records_of(std::span<const Record> records, const std::vector<Member>& members) {
  auto* copy = new std::vector<Record>(records.begin(), records.end());
  const nb::capsule owner(copy, [](void* memory) noexcept { delete static_cast<std::vector<Record>*>(memory); });
  const std::size_t bytes = copy->size() * sizeof(Record);
  nb::object raw = nb::ndarray<nb::numpy, std::uint8_t, nb::ndim<1>>(copy->data(), {bytes}, owner).cast();
  return raw.attr("view")(record_type(members, sizeof(Record)));
}

}  // namespace atl::python

namespace nanobind::detail {

template <typename T, typename... Dimensions>
struct type_caster<atl::python::ArrayLike<T, Dimensions...>> {
  using Taken = atl::python::ArrayLike<T, Dimensions...>;
  NB_TYPE_CASTER(Taken, const_name("numpy.typing.ArrayLike"))

  bool from_python(handle src, std::uint8_t, cleanup_list* cleanup) noexcept {
    if (src.is_none()) return false;
    if (take(src, cleanup)) return true;
    try {
      const object array =
          atl::python::numpy_array(src, std::is_integral_v<T> ? "uint32" : "float64", std::is_integral_v<T>);
      if (array.is_none()) return false;
      if (take(array, cleanup)) return true;
      std::string wanted;
      ((wanted += atl::python::words_of(Dimensions{})), ...);
      atl::python::refusal() =
          cast<std::string>(str("found numbers of shape {}; expected ").format(array.attr("shape")));
      atl::python::refusal() += wanted;
    } catch (const std::exception& error) {
      atl::python::refusal() = "found what makes no array of numbers: " + std::string(error.what());
    }
    return false;
  }

 private:
  bool take(handle array, cleanup_list* cleanup) noexcept {
    make_caster<ndarray<const T, Dimensions..., c_contig, device::cpu>> caster;
    if (!caster.from_python(array, 0, cleanup)) return false;
    value = Taken{std::move(caster.value)};
    return true;
  }
};

}  // namespace nanobind::detail
