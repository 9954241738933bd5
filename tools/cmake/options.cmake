# SPDX-License-Identifier: MIT
# What every target of the project is compiled with. All of it ends with the project's own folders.

set(CMAKE_C_STANDARD 11)
set(CMAKE_C_STANDARD_REQUIRED ON)
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# A simulation gives the same bytes on each PC and with each compiler: no fused
# multiply-add, no fast-math, no code tuned to the machine that builds it.
add_compile_options(-ffp-contract=off)

# Linked privately by each target of ours, so third-party code is not judged by it.
add_library(nf_warnings INTERFACE)

# nf_count(<target> [FUNCTIONS_ONLY])
#
# Counted if NF_COVERAGE: each statement, branch and condition, or only whether a function runs, which is much faster.
function(nf_count target)
    if(NF_COVERAGE)
        cmake_parse_arguments(PARSE_ARGV 1 arg "FUNCTIONS_ONLY" "" "")
        target_compile_options(${target} PRIVATE -fprofile-instr-generate)
        target_link_options(${target} PUBLIC -fprofile-instr-generate)
        if(NOT arg_FUNCTIONS_ONLY)
            target_compile_options(${target} PRIVATE -fcoverage-mapping -fcoverage-mcdc)
        endif()
    endif()
endfunction()

# As part of another project it has no settings of its own, and another compiler may warn of other things.
if(NOT PROJECT_IS_TOP_LEVEL)
    return()
endif()

# The firmware and the plant are C, are debugged and take most of a run. C++ takes most of the time to compile: it gets line
# numbers, and is optimised where nf_optimise() says so. gcc looks for memory to free only beyond 400 MB.
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O0 -g1 -DNDEBUG")
add_compile_options("$<$<COMPILE_LANG_AND_ID:CXX,GNU>:--param=ggc-min-heapsize=400000>")

target_compile_options(nf_warnings INTERFACE
    -Wall -Wextra -Wconversion -Wsign-conversion -Wshadow -Wdouble-promotion -Wundef -Wvla
    -pedantic -Werror
    $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes>)

option(NF_FUZZ "Link the programs of tests/fuzz with libFuzzer" OFF)
set(NF_TEST_FOLDERS "" CACHE STRING "Folders of tests/ that are built and run; empty: all")
option(NF_GATES "Register the quality gates as tests" ON)

# Off by default: a precompiled header hides an #include that is missing.
option(CMAKE_DISABLE_PRECOMPILE_HEADERS "Compile without precompiled headers" OFF)
option(NF_COVERAGE "Count what the tests run (clang)" OFF)

set(UNITY_ROOT ${PROJECT_SOURCE_DIR}/.cache/unity-2.5.1 CACHE PATH "Folder of the Unity test framework")
set(NF_PYTHON ${PROJECT_SOURCE_DIR}/.cache/venv/bin/python CACHE FILEPATH "Python of the tools")
