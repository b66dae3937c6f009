#pragma once
/// Hulls, meshes and height fields, of which there is one object of Python as long as anybody has it: so a pickle that
/// many bodies share one in has it once, and so have the bodies that it is read into.

#include <atoll/shapes.h>
#include <nanobind/nanobind.h>

#include <cstdint>
#include <type_traits>

namespace atl::python {

namespace nb = nanobind;

/// A WeakValueDictionary of these objects by where their geometry is, which they keep there.
inline nb::object shared_geometry() { return nb::module_::import_("atoll._core").attr("_shared_geometry"); }

}  // namespace atl::python

namespace nanobind::detail {

template <typename Geometry>
struct shared_geometry_caster : type_caster_base<Geometry> {
  template <typename T>
  static handle from_cpp(T&& value, rv_policy policy, cleanup_list* cleanup) noexcept {
    const Geometry* geometry = nullptr;
    if constexpr (std::is_pointer_v<std::remove_reference_t<T>>) {
      geometry = value;
    } else {
      geometry = &value;
    }
    if (geometry == nullptr) return none().release();
    try {
      const object known = atl::python::shared_geometry();
      const auto key = reinterpret_cast<std::uintptr_t>(geometry->data().get());
      object found = known.attr("get")(key);
      if (found.is_none()) {
        // A copy, as the geometry is shared anyway.
        found = steal(type_caster_base<Geometry>::from_cpp(*geometry, rv_policy::copy, cleanup));
        if (found.is_valid()) known.attr("__setitem__")(key, found);
      }
      return found.release();
    } catch (python_error& error) {
      error.restore();
      return {};
    }
  }
};

template <>
struct type_caster<atl::ConvexHull> : shared_geometry_caster<atl::ConvexHull> {};
template <>
struct type_caster<atl::TriangleMesh> : shared_geometry_caster<atl::TriangleMesh> {};
template <>
struct type_caster<atl::HeightField> : shared_geometry_caster<atl::HeightField> {};

}  // namespace nanobind::detail
