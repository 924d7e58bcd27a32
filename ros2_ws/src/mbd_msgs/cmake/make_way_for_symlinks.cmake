# A build without --symlink-install leaves a folder where a build with it wants a link, and CMake stops on it. So that
# the two may follow one another in either order, remove it.
set(_copied ${CMAKE_CURRENT_BINARY_DIR}/ament_cmake_python/${PROJECT_NAME}/${PROJECT_NAME})
if(AMENT_CMAKE_SYMLINK_INSTALL AND IS_DIRECTORY ${_copied} AND NOT IS_SYMLINK ${_copied})
  file(REMOVE_RECURSE ${_copied})
endif()
