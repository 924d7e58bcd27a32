# Interfaces of other packages, stated again for the PyPI wheels, which do not have them. Only tools/build builds these,
# and only with the wheels: a normal ROS 2 install, or the vendor's driver, has the real ones.
include(${CMAKE_CURRENT_LIST_DIR}/../src/mbd_msgs/cmake/drop_missing_include_directories.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/../src/mbd_msgs/cmake/make_way_for_symlinks.cmake)

macro(state_again)
  find_package(ament_cmake REQUIRED)
  foreach(package ${ARGN})
    find_package(${package} REQUIRED)
  endforeach()
  find_package(rosidl_default_generators REQUIRED)
  # Nothing here is written in C++.
  list(FILTER AMENT_EXTENSIONS_rosidl_generate_idl_interfaces EXCLUDE REGEX "_cpp:")
  file(GLOB interfaces RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} CONFIGURE_DEPENDS msg/*.msg srv/*.srv action/*.action)
  rosidl_generate_interfaces(${PROJECT_NAME} ${interfaces} DEPENDENCIES ${ARGN})
  # One file in place of thirty that each read all of Fast DDS' headers: a sixth of the compiler's time.
  set_target_properties(
    ${PROJECT_NAME}__rosidl_typesupport_fastrtps_c ${PROJECT_NAME}__rosidl_typesupport_c
    PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
  ament_export_dependencies(rosidl_default_runtime)
  ament_package()
endmacro()
