# The rules on includes, label `layers`: none runs upward, users see no internals, public headers stand alone.
# A test hands the compiler one include, a target's include directories and nothing else.
function(atoll_include_test name target header)
  set(probe ${CMAKE_CURRENT_BINARY_DIR}/layers/${name}.cpp)
  file(CONFIGURE OUTPUT ${probe} CONTENT "#include <${header}>\n")
  set(directories $<TARGET_PROPERTY:${target},INTERFACE_INCLUDE_DIRECTORIES>)
  add_test(NAME ${name} COMMAND_EXPAND_LISTS
           COMMAND ${CMAKE_CXX_COMPILER} -std=c++20 -fsyntax-only
                   "$<$<BOOL:${directories}>:-I$<JOIN:${directories},;-I>>" ${probe})
  set_tests_properties(${name} PROPERTIES LABELS layers)
endfunction()

set(below)
foreach(layer jobs collision solver)
  set(root ${PROJECT_SOURCE_DIR}/${layer}/include)
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${root} ${root}/*.h)
  list(GET headers 0 header)
  # The layer itself does find the header, so the tests after this fail on the include's direction alone.
  atoll_include_test(layers.${layer}_sees_itself atoll_${layer} ${header})
  foreach(target IN LISTS below ITEMS atoll)
    string(REPLACE atoll_ "" name ${target})
    atoll_include_test(layers.${name}_does_not_see_${layer} ${target} ${header})
    set_tests_properties(layers.${name}_does_not_see_${layer} PROPERTIES
                         PASS_REGULAR_EXPRESSION "No such file or directory|file not found")
  endforeach()
  list(APPEND below atoll_${layer})
endforeach()

foreach(path IN LISTS public_headers)
  cmake_path(GET path STEM name)
  if(ATOLL_LONG_TESTS OR name STREQUAL "atoll")
    atoll_include_test(layers.public_${name}_stands_alone atoll atoll/${name}.h)
  endif()
endforeach()

# What lasts of a world is told in one place, which does not compile while a member of a store is missing there.
add_test(NAME layers.no_member_of_a_store_is_forgotten COMMAND_EXPAND_LISTS
         COMMAND ${PROJECT_SOURCE_DIR}/tests/forgotten_member.sh ${CMAKE_CURRENT_BINARY_DIR}/forgotten
                 ${CMAKE_CXX_COMPILER} "-I$<JOIN:$<TARGET_PROPERTY:atoll_runtime,INCLUDE_DIRECTORIES>,;-I>")
# A class has a subject: no more than 25 functions, or 15 members beside functions.
add_test(NAME layers.no_class_does_everything
         COMMAND python3 ${PROJECT_SOURCE_DIR}/tests/class_sizes.py ${PROJECT_SOURCE_DIR})
set_tests_properties(layers.no_member_of_a_store_is_forgotten layers.no_class_does_everything
                     PROPERTIES LABELS layers)
