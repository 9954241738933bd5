# SPDX-License-Identifier: MIT
# find_package(neurofoc): the targets neurofoc::core, neurofoc::app and, for the PC, neurofoc::plant, compiled as the project
# that asks for them is; and the functions of hal/config.cmake and hal/cortex_m/image.cmake.
if(NOT TARGET neurofoc::core)
    add_subdirectory(${CMAKE_CURRENT_LIST_DIR}/.. ${CMAKE_CURRENT_BINARY_DIR}/neurofoc_package)
endif()
