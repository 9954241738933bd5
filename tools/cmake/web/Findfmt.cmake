# SPDX-License-Identifier: MIT
include(${CMAKE_CURRENT_LIST_DIR}/header_only.cmake)
nf_header_folder(fmt fmt)
if(NOT TARGET fmt::fmt)
    # Compiled once. A page has one locale: without the code for others it is smaller.
    add_library(nf_fmt STATIC ${CMAKE_CURRENT_LIST_DIR}/fmt.cpp)
    target_include_directories(nf_fmt SYSTEM PUBLIC ${NF_fmt_FOLDER})
    target_compile_definitions(nf_fmt PUBLIC FMT_STATIC_THOUSANDS_SEPARATOR=',')
    add_library(fmt::fmt ALIAS nf_fmt)
endif()
set(fmt_FOUND TRUE)
