# SPDX-License-Identifier: MIT
include(${CMAKE_CURRENT_LIST_DIR}/header_only.cmake)
nf_header_only(fmt::fmt fmt)
set_target_properties(fmt::fmt PROPERTIES INTERFACE_COMPILE_DEFINITIONS FMT_HEADER_ONLY)
set(fmt_FOUND TRUE)
