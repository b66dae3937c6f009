# How a build gets by with a quarter of the compiler's time: most of a file's time is that of headers which it shares with
# all others.

# Files of a target are compiled together, some at a time. Batches of so many files; or GROUP, by the sources' property
# UNITY_GROUP.
function(atoll_unity target)
  cmake_parse_arguments(PARSE_ARGV 1 unity GROUP BATCH "")
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${ATOLL_UNITY})
  if(unity_GROUP)
    set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
  else()
    set_target_properties(${target} PROPERTIES UNITY_BUILD_BATCH_SIZE ${unity_BATCH})
  endif()
endfunction()

# What nearly every file includes of the standard library and Eigen, compiled once for each level of optimisation.
function(atoll_precompiled target)
  set(source ${PROJECT_BINARY_DIR}/${target}.cpp)
  file(CONFIGURE OUTPUT ${source} CONTENT "")
  add_library(${target} OBJECT ${source})
  target_link_libraries(${target} PRIVATE atoll_flags Eigen3::Eigen)
  target_compile_options(${target} PRIVATE ${ARGN})
  target_precompile_headers(${target} PRIVATE
    <Eigen/Core> <Eigen/Geometry> <algorithm> <array> <cmath> <cstddef> <cstdint> <filesystem> <functional> <limits> <map>
    <memory> <optional> <span> <sstream> <string> <tuple> <utility> <variant> <vector>)
endfunction()

# GCC inlines less once a unit has grown by a part of its size: which files are compiled together would decide how fast
# they get, by 6% in piles of hulls. A precompiled header must be compiled alike, or these options are its own.
set(on_the_step $<$<AND:$<CXX_COMPILER_ID:GNU>,$<CONFIG:Release>>:--param=inline-unit-growth=200>)

# What no step runs is optimised less, which takes a third less time to compile.
set(off_the_step $<$<CONFIG:Release>:-O1>)
atoll_precompiled(atoll_precompiled_on_the_step ${on_the_step})
atoll_precompiled(atoll_precompiled_off_the_step ${off_the_step})

function(atoll_on_the_step target)
  target_compile_options(${target} PRIVATE ${on_the_step})
  target_precompile_headers(${target} REUSE_FROM atoll_precompiled_on_the_step)
endfunction()
function(atoll_off_the_step target)
  target_compile_options(${target} PRIVATE ${off_the_step})
  target_precompile_headers(${target} REUSE_FROM atoll_precompiled_off_the_step)
endfunction()

# GCC looks through its memory for what it may use again, which takes a seventh of its time. Where each compiler has 3 GB
# it needn't; one takes up to 1.3 GB then, and otherwise 1.1.
cmake_host_system_information(RESULT memory QUERY TOTAL_PHYSICAL_MEMORY)
cmake_host_system_information(RESULT cores QUERY NUMBER_OF_LOGICAL_CORES)
math(EXPR each "${memory} / ${cores}")
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND each GREATER 3000)
  target_compile_options(atoll_flags INTERFACE --param=ggc-min-heapsize=2000000)
endif()
