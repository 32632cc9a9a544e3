# The core for other C++ programs: library, headers and the CMake package `rollerrig`, docs/how_to/cpp.md.
#
#   cmake --install BUILD --component development --prefix PREFIX  ->  find_package(rollerrig)  ->  rollerrig::core
#
# `pip install` leaves it out. What the library was compiled with (-march) is part of the target: layouts depend on it.
include(CMakePackageConfigHelpers)

set_target_properties(rollerrig_core PROPERTIES EXPORT_NAME core)
set_target_properties(rollerrig_code_generation PROPERTIES EXPORT_NAME code_generation)
set(package lib/cmake/rollerrig)
set(development COMPONENT development EXCLUDE_FROM_ALL)

install(TARGETS rollerrig_core rollerrig_code_generation EXPORT rollerrig ARCHIVE DESTINATION lib ${development})
install(DIRECTORY core/include/rollerrig DESTINATION include ${development} FILES_MATCHING PATTERN "*.hpp")
install(EXPORT rollerrig NAMESPACE rollerrig:: FILE targets.cmake DESTINATION ${package} ${development})

set(config ${CMAKE_CURRENT_BINARY_DIR}/package/rollerrig-config.cmake)
file(CONFIGURE OUTPUT ${config} @ONLY CONTENT [[
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 3.4 HINTS "@Eigen3_DIR@")
include("${CMAKE_CURRENT_LIST_DIR}/targets.cmake")
]])
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/package/rollerrig-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/package/ DESTINATION ${package} ${development})
