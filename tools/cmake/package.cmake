# SPDX-License-Identifier: MIT
# What `cmake --install` puts into a prefix: nfconfig, its data, and the firmware as source, because an image compiles it
# for its own core. share/neurofoc is this project's folder without simulator and tests, and is added as a subproject.
include(CMakePackageConfigHelpers)

set(share share/neurofoc) # nfconfig looks there, from its folder
set(kinds FILES_MATCHING PATTERN "*.[chS]" PATTERN "*.def" PATTERN "*.ld" PATTERN "*.cmake" PATTERN "CMakeLists.txt")

install(TARGETS nfconfig RUNTIME DESTINATION bin)
install(FILES CMakeLists.txt LICENSE DESTINATION ${share})
install(FILES tools/cmake/options.cmake tools/cmake/floors.cmake DESTINATION ${share}/tools/cmake)
install(DIRECTORY firmware DESTINATION ${share} ${kinds})
install(FILES hal/CMakeLists.txt hal/config.cmake hal/hal.h DESTINATION ${share}/hal)
install(DIRECTORY hal/cortex_m DESTINATION ${share}/hal ${kinds})
install(DIRECTORY host_sim/plant DESTINATION ${share}/host_sim ${kinds})
foreach(folder IN ITEMS motors boards tunings imperfections scenarios)
    install(DIRECTORY host_sim/${folder} DESTINATION ${share}/host_sim FILES_MATCHING PATTERN "*.toml")
endforeach()

# Source is for any machine. Before 1.0 a minor version may change what is called how.
set(version ${CMAKE_CURRENT_BINARY_DIR}/neurofocConfigVersion.cmake)
write_basic_package_version_file(${version} COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES tools/cmake/neurofocConfig.cmake ${version} DESTINATION ${share}/cmake)
