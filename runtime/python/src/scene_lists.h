#pragma once
/// Lists of a scene's bodies and joints that Python was handed. They stay the scene's own: what is done to them and to
/// their elements counts wherever the scene is used next.

#include <atoll/scene.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <vector>

#include "casters.h"

namespace atl::python {

/// A WeakKeyDictionary from scenes to their lists by name.
inline nb::object scene_lists() { return nb::module_::import_("atoll._core").attr("_scene_lists"); }

/// False, and a refusal, unless a list is one of such parts.
template <typename Part>
bool read_parts(nb::handle list, const char* name, std::vector<Part>& parts) {
  if (list.is_none() || nb::try_cast(list, parts)) return true;
  refusal() = "Scene." + std::string(name) + ": found something else in it; expected " +
              nb::cast<std::string>(nb::type<Part>().attr("__name__")) + " in each place";
  return false;
}

}  // namespace atl::python

namespace nanobind::detail {

template <>
struct type_caster<atl::Scene> : type_caster_base<atl::Scene> {
  bool from_python(handle src, std::uint32_t flags, cleanup_list* cleanup) noexcept {
    if (!type_caster_base<atl::Scene>::from_python(src, flags, cleanup)) return false;
    if (src.is_none()) return true;
    try {
      const object lists = atl::python::scene_lists().attr("get")(src);
      if (lists.is_none()) return true;
      atl::Scene& scene = *this;
      const object get = lists.attr("get");
      return atl::python::read_parts(get("bodies"), "bodies", scene.bodies) &&
             atl::python::read_parts(get("joints"), "joints", scene.joints) &&
             atl::python::read_parts(get("material_pairs"), "material_pairs", scene.material_pairs);
    } catch (python_error&) {
      return false;
    }
  }
};

}  // namespace nanobind::detail
