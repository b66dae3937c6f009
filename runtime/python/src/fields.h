#pragma once
/// Structs of named values as Python classes: keyword arguments with the struct's own defaults, attributes, a repr that
/// tells what is not as it is by default, and pickling.

#include <atoll/error.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <tuple>
#include <utility>

#include "casters.h"
#include "scene_lists.h"
#include "shared_geometry.h"

namespace atl::python {

template <typename T, typename M>
struct Field {
  const char* name;
  M T::*member;
  const char* doc;
};
template <typename T, typename M>
Field(const char*, M T::*, const char*) -> Field<T, M>;

/// "Sphere(radius=2.0)".
template <typename T, typename... M>
std::string words_of(const char* name, const T& values, const Field<T, M>&... fields) {
  const T defaults{};
  std::string words = std::string(name) + "(";
  const auto add = [&](const char* field, const nb::object& value, const nb::object& default_value) {
    const std::string text = nb::repr(value).c_str();
    if (text == nb::repr(default_value).c_str()) return;
    words += (words.back() == '(' ? "" : ", ") + std::string(field) + "=" + text;
  };
  (add(fields.name, nb::cast(values.*(fields.member)), nb::cast(defaults.*(fields.member))), ...);
  return words + ")";
}

/// Throws Error if an object is about to be freed, as in world.settings.substeps = 8: attributes and calls hand out
/// copies, so such a line would change nothing. Newer interpreters also lend what a variable holds, uncounted.
inline void refuse_if_lost(nb::handle object, const std::string& name) {
#if PY_VERSION_HEX >= 0x030E0000
  const bool lost = PyUnstable_Object_IsUniqueReferencedTemporary(object.ptr()) != 0;
#else
  const bool lost = Py_REFCNT(object.ptr()) == 1;
#endif
  if (!lost) return;
  throw Error(name + ": set on a copy that nobody keeps, so nothing would change; expected copy = ...; copy." +
              name.substr(name.find('.') + 1) +
              " = ...; and the copy put back as a whole, as by world.settings = copy");
}

/// Attributes and pickling.
template <typename T, typename... M>
void bind_values(nb::class_<T>& type, const Field<T, M>&... fields) {
  const std::string name = nb::cast<std::string>(type.attr("__name__")) + ".";
  // By value: a reference into an optional or a variant would outlive what it refers to.
  (type.def_prop_rw(
       fields.name, [member = fields.member](const T& self) -> M { return self.*member; },
       [member = fields.member, name = name + fields.name](nb::handle_t<T> self, M value) {
         refuse_if_lost(self, name);
         nb::cast<T&>(self).*member = std::move(value);
       },
       fields.doc),
   ...);
  type.def("__getstate__", [=](const T& self) { return std::tuple<M...>(self.*(fields.member)...); });
  type.def("__setstate__", [=](T& self, const std::tuple<M...>& state) {
    new (&self) T{};
    std::apply([&](const M&... values) { ((self.*(fields.member) = values), ...); }, state);
  });
}

template <typename T, typename... M>
void bind_repr(nb::class_<T>& type, const Field<T, M>&... fields) {
  const std::string name = nb::cast<std::string>(type.attr("__name__"));
  type.def("__repr__", [=](const T& self) { return words_of(name.c_str(), self, fields...); });
}

/// A constructor that takes all of them: after `extra`, which may be nb::kw_only().
template <typename T, typename... M, typename... Extra>
void bind_constructor(nb::class_<T>& type, const std::tuple<Extra...>& extra, const Field<T, M>&... fields) {
  const T defaults{};
  std::apply(
      [&](const Extra&... first) {
        type.def(
            "__init__",
            [=](T* self, M... values) {
              new (self) T{};
              ((self->*(fields.member) = std::move(values)), ...);
            },
            first..., (nb::arg(fields.name) = defaults.*(fields.member))...);
      },
      extra);
}

/// All of it, with fields in order or by name.
template <typename T, typename... M>
void bind_struct(nb::class_<T>& type, const Field<T, M>&... fields) {
  bind_constructor(type, std::tuple<>(), fields...);
  bind_values(type, fields...);
  bind_repr(type, fields...);
}

/// All of it, with fields by name only.
template <typename T, typename... M>
void bind_definition(nb::class_<T>& type, const Field<T, M>&... fields) {
  bind_constructor(type, std::tuple(nb::kw_only()), fields...);
  bind_values(type, fields...);
  bind_repr(type, fields...);
}

/// Attributes that tell of what was done.
template <typename T, typename... M>
void bind_result(nb::class_<T>& type, const Field<T, M>&... fields) {
  (type.def_prop_ro(
       fields.name, [member = fields.member](const T& self) -> M { return self.*member; }, fields.doc),
   ...);
  bind_repr(type, fields...);
}

}  // namespace atl::python
