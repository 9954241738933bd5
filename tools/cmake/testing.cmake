# SPDX-License-Identifier: MIT
# The Unity test framework, as a library, and one function to add a test of it.

find_path(UNITY_SOURCE_DIR unity.c
    PATHS ${UNITY_ROOT} PATH_SUFFIXES src NO_DEFAULT_PATH NO_CACHE)
if(NOT UNITY_SOURCE_DIR)
    message(FATAL_ERROR
        "There is no unity.c in ${UNITY_ROOT}.\n"
        "Run `tools/dev setup`, or give a copy of Unity with -DUNITY_ROOT=DIR.")
endif()

set(support ${CMAKE_SOURCE_DIR}/tests/support)
add_library(unity STATIC ${UNITY_SOURCE_DIR}/unity.c ${support}/testing.c ${support}/main.c)
target_include_directories(unity SYSTEM PUBLIC ${UNITY_SOURCE_DIR})
target_include_directories(unity PUBLIC ${support})
target_compile_definitions(unity PUBLIC UNITY_SUPPORT_64 UNITY_INCLUDE_DOUBLE)
if(NF_COVERAGE)
    target_sources(unity PRIVATE ${CMAKE_SOURCE_DIR}/tests/evidence/each_test.c)
    target_link_options(unity INTERFACE -Wl,--wrap=UnityDefaultTestRun -fprofile-instr-generate)
endif()

# nf_add_unit_test(<name> SOURCES <file>... [LINK <target>...])
#
# A program of Unity tests, C or C++, registered under its own name.
function(nf_add_unit_test name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINK")
    add_executable(${name} ${arg_SOURCES})
    target_link_libraries(${name} PRIVATE ${arg_LINK} unity nf_warnings)
    nf_precompile(${name})
    add_test(NAME ${name} COMMAND ${name})
endfunction()

# nf_is_evidence(<test>...)
#
# Run by `tools/dev evidence` alone, as a test of one of the parts in tools/evidence/parts.toml.
function(nf_is_evidence)
    set_property(TEST ${ARGV} APPEND PROPERTY LABELS evidence)
endfunction()

# nf_add_many_runs(<name> [CORES <n>] [FIXTURE <name>] COMMAND <command>...)
#
# A test of the evidence alone, with as many runs as testing_runs() gives to it.
function(nf_add_many_runs name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "CORES;FIXTURE" "COMMAND")
    if(NF_GATES)
        add_test(NAME ${name} COMMAND ${arg_COMMAND})
        set_tests_properties(${name} PROPERTIES ENVIRONMENT NF_MANY_RUNS=1 TIMEOUT 3000
            PROCESSORS "${arg_CORES}" FIXTURES_REQUIRED "${arg_FIXTURE}")
        nf_is_evidence(${name})
    endif()
endfunction()

# nf_also_with_many_runs(<test> [CORES <n>] [FIXTURE <name>] COMMAND <command>...)
#
# many.<test>: the same command as that of a test, as nf_add_many_runs().
function(nf_also_with_many_runs test)
    nf_add_many_runs(many.${test} ${ARGN})
endfunction()

# nf_is_dear(<test> <reason>)
#
# It stays in `tools/dev test` though it takes more than a test may (tools/gates/run_tests.py).
function(nf_is_dear test reason)
    if(reason STREQUAL "")
        message(FATAL_ERROR "${test}: a reason is missing")
    endif()
    set_property(TEST ${test} APPEND PROPERTY LABELS dear)
endfunction()

# Counts that another build has left are not those of this one.
set(counts ${CMAKE_BINARY_DIR}/profiles)
if(NF_COVERAGE)
    add_custom_target(no_counts ALL COMMAND ${CMAKE_COMMAND} -E rm -rf ${counts})
endif()

# nf_count_tests()
#
# Of each test of this folder, which calls it last: its counts are left in profiles/<test>.<process>.profraw.
function(nf_count_tests)
    if(NF_COVERAGE)
        get_property(tests DIRECTORY PROPERTY TESTS)
        foreach(test IN LISTS tests)
            set_property(TEST ${test} APPEND PROPERTY ENVIRONMENT "LLVM_PROFILE_FILE=${counts}/${test}.%p.profraw")
        endforeach()
    endif()
endfunction()
