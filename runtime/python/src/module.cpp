#include "parts.h"

NB_MODULE(_core, module) {
  using namespace atl::python;
  module.doc() = "Atoll's classes and functions, as the package atoll hands them on.";
  module.attr("version") = ATOLL_VERSION;
  bind_types(module);
  bind_shapes(module);
  bind_joints(module);
  bind_settings(module);
  bind_reports(module);
  bind_callbacks(module);
  bind_world(module);
  bind_mechanisms(module);
  bind_queries(module);
  bind_recordings(module);
  bind_scenes(module);
  bind_films(module);
  bind_sweeps(module);
  bind_batch(module);
  explain_arguments(module);
}
