# SPDX-License-Identifier: MIT
include(${CMAKE_CURRENT_LIST_DIR}/header_only.cmake)
nf_header_only(tomlplusplus::tomlplusplus toml++)
set(tomlplusplus_FOUND TRUE)
