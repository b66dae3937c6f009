# What a build for a small target may leave out: what is more than 1% of the libraries, or of a step (perf/features.sh
# measures both). C++ sees each choice as a constant in a generated header of its own, so that what doesn't ask for it is
# not compiled again: ATOLL_WITH_JOINTS as atl::with_joints in features/with_joints.h, for all layers. Who enters a
# capability asks there, and what is behind it is then not linked. A scene that does without it comes to the same bits
# either way, and a call that asks for it throws atl::Error.
set(features_dir ${PROJECT_BINARY_DIR}/features)
function(atoll_feature name what)
  option(ATOLL_WITH_${name} "Build with ${what}" ON)
  string(TOLOWER with_${name} constant)
  set(value false)
  if(ATOLL_WITH_${name})
    set(value true)
  endif()
  set_property(GLOBAL APPEND PROPERTY ATOLL_FEATURES ${name})
  configure_file(${CMAKE_CURRENT_FUNCTION_LIST_DIR}/with.h.in ${features_dir}/features/${constant}.h @ONLY)
endfunction()

atoll_feature(JOINTS "joints")
atoll_feature(MESHES "triangle meshes and height fields")
atoll_feature(HULLS "convex hulls of points")
atoll_feature(SURFACES "rolling and torsional friction, and surfaces that run")
atoll_feature(RESTITUTION "bounces")
atoll_feature(CONTINUOUS "sweeps of fast bodies")
atoll_feature(DIRECT_CONTACTS "direct solves and finer substeps of what sweeps can't hold up")
atoll_feature(SNAPSHOTS "snapshots")
atoll_feature(RECORDING "recordings")

if(ATOLL_WITH_RECORDING AND NOT ATOLL_WITH_SNAPSHOTS)
  message(FATAL_ERROR "ATOLL_WITH_RECORDING is ON and ATOLL_WITH_SNAPSHOTS is OFF; expected both ON, or the first OFF: "
                      "a recording begins with a snapshot")
endif()
