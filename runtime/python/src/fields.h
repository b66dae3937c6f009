#pragma once
/// Structs of named values as Python classes: keyword arguments with the struct's own defaults, attributes, a repr that
/// tells what is not as it is by default, and pickling.

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
  const auto add = [&](const char* field, const nb::object& value, const nb::object& usual) {
    const std::string text = nb::repr(value).c_str();
    if (text == nb::repr(usual).c_str()) return;
    words += (words.back() == '(' ? "" : ", ") + std::string(field) + "=" + text;
  };
  (add(fields.name, nb::cast(values.*(fields.member)), nb::cast(defaults.*(fields.member))), ...);
  return words + ")";
}

/// Attributes, repr and pickling; no way to make one but to copy.
template <typename T, typename... M>
void bind_values(nb::class_<T>& type, const Field<T, M>&... fields) {
  const std::string name = nb::cast<std::string>(type.attr("__name__"));
  // By value: a reference into an optional or a variant would outlive what it refers to.
  (type.def_prop_rw(
       fields.name, [member = fields.member](const T& self) -> M { return self.*member; },
       [member = fields.member](T& self, M value) { self.*member = std::move(value); }, fields.doc),
   ...);
  type.def("__repr__", [=](const T& self) { return words_of(name.c_str(), self, fields...); });
  type.def("__getstate__", [=](const T& self) { return std::tuple<M...>(self.*(fields.member)...); });
  type.def("__setstate__", [=](T& self, const std::tuple<M...>& state) {
    new (&self) T{};
    std::apply([&](const M&... values) { ((self.*(fields.member) = values), ...); }, state);
  });
}

/// That, and a constructor that takes all of them, in order or by name.
template <typename T, typename... M>
void bind_struct(nb::class_<T>& type, const Field<T, M>&... fields) {
  const T defaults{};
  type.def(
      "__init__",
      [=](T* self, M... values) {
        new (self) T{};
        ((self->*(fields.member) = std::move(values)), ...);
      },
      (nb::arg(fields.name) = defaults.*(fields.member))...);
  bind_values(type, fields...);
}

/// The same, by name only.
template <typename T, typename... M>
void bind_definition(nb::class_<T>& type, const Field<T, M>&... fields) {
  const T defaults{};
  type.def(
      "__init__",
      [=](T* self, M... values) {
        new (self) T{};
        ((self->*(fields.member) = std::move(values)), ...);
      },
      nb::kw_only(), (nb::arg(fields.name) = defaults.*(fields.member))...);
  bind_values(type, fields...);
}

/// Attributes that tell of what was done.
template <typename T, typename... M>
void bind_result(nb::class_<T>& type, const Field<T, M>&... fields) {
  const std::string name = nb::cast<std::string>(type.attr("__name__"));
  (type.def_prop_ro(
       fields.name, [member = fields.member](const T& self) -> M { return self.*member; }, fields.doc),
   ...);
  type.def("__repr__", [=](const T& self) { return words_of(name.c_str(), self, fields...); });
}

}  // namespace atl::python
