# SPDX-License-Identifier: MIT
include(${CMAKE_CURRENT_LIST_DIR}/header_only.cmake)
nf_header_only(Eigen3::Eigen Eigen /usr/include/eigen3)
set(Eigen3_FOUND TRUE)
