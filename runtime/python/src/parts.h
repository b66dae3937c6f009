#pragma once
/// The pieces that the module is made of, in the order in which they need each other.

#include <nanobind/nanobind.h>

namespace atl::python {

void bind_types(nanobind::module_& module);  // errors, ids, poses, enums
void bind_shapes(nanobind::module_& module);
void bind_joints(nanobind::module_& module);
void bind_settings(nanobind::module_& module);
void bind_reports(nanobind::module_& module);
void bind_callbacks(nanobind::module_& module);
void bind_world(nanobind::module_& module);
void bind_mechanisms(nanobind::module_& module);
void bind_queries(nanobind::module_& module);
void bind_recordings(nanobind::module_& module);
void bind_scenes(nanobind::module_& module);
void bind_films(nanobind::module_& module);  // views of worlds and recordings
void bind_sweeps(nanobind::module_& module);
void bind_batch(nanobind::module_& module);
void explain_arguments(nanobind::module_& module);  // of all functions that there are by then

}  // namespace atl::python
