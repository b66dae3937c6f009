#pragma once
/// Many bodies at once: arrays of a row each.

#include <atoll/types.h>
#include <atoll/world.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "casters.h"

namespace atl::python {

/// An array of float64 that is passed in, C-contiguous; others are converted on the way.
template <int columns>
using Rows = nb::ndarray<const double, nb::shape<-1, columns>, nb::c_contig, nb::device::cpu>;
/// The same with any number of columns.
using Heights = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

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
