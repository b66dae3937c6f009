# Installs the libraries, the public headers, the command and the package that find_package(atoll) reads.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/atoll)

install(TARGETS atoll atoll_scene atoll_runtime atoll_solver atoll_collision atoll_jobs EXPORT atollTargets
        FILE_SET HEADERS)
install(EXPORT atollTargets NAMESPACE atoll:: DESTINATION ${package_dir})
if(TARGET atoll_command)
  install(TARGETS atoll_command)
endif()

get_property(features GLOBAL PROPERTY ATOLL_FEATURES)
set(built_with "")
foreach(feature IN LISTS features)
  string(APPEND built_with "set(atoll_WITH_${feature} ${ATOLL_WITH_${feature}})\n")
endforeach()
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/atollConfig.cmake.in ${PROJECT_BINARY_DIR}/atollConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
# Before 1.0 a minor version may break its users.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/atollConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/atollConfig.cmake ${PROJECT_BINARY_DIR}/atollConfigVersion.cmake
        DESTINATION ${package_dir})

# For builds without CMake. The libraries are static, so all that they need is named.
set(pkgconfig_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH atoll_prefix_from_pc /${pkgconfig_dir} /)
configure_file(${CMAKE_CURRENT_LIST_DIR}/atoll.pc.in ${PROJECT_BINARY_DIR}/atoll.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/atoll.pc DESTINATION ${pkgconfig_dir})

install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/runtime/examples DESTINATION ${CMAKE_INSTALL_DOCDIR} FILES_MATCHING PATTERN "*.cpp")
