# SPDX-License-Identifier: MIT
# nf_optimise(<target>)
#
# C++ in which the runs spend their time: optimised where other C++ is not. Headers precompiled without optimisation do not fit it.
function(nf_optimise target)
    if(NOT EMSCRIPTEN)
        target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-O1>)
        set_target_properties(${target} PROPERTIES DISABLE_PRECOMPILE_HEADERS ON)
    endif()
endfunction()

# nf_precompile(<target>)
#
# C++ of the host takes the headers of the libraries, precompiled for nf_file, or for nf_design with Eigen; where
# CMAKE_DISABLE_PRECOMPILE_HEADERS is off, as in the preset host-asan. Eigen without optimisation takes longer to compile, and a
# hundred times longer to run.
function(nf_precompile target)
    get_target_property(sources ${target} SOURCES)
    get_target_property(linked ${target} LINK_LIBRARIES)
    if(NOT TARGET nf_file OR sources MATCHES "[.]c(;|$)" OR target STREQUAL nf_file)
        return()
    elseif(linked MATCHES "nf_(design|twins)|Eigen3")
        nf_optimise(${target})
        nf_precompile_with_eigen(${target})
    else()
        target_precompile_headers(${target} REUSE_FROM nf_file)
    endif()
endfunction()

# The headers of nf_design are precompiled with the same optimisation, so they fit after nf_optimise().
function(nf_precompile_with_eigen target)
    if(TARGET nf_design)
        set_target_properties(${target} PROPERTIES DISABLE_PRECOMPILE_HEADERS ${CMAKE_DISABLE_PRECOMPILE_HEADERS})
        if(NOT target STREQUAL nf_design)
            target_precompile_headers(${target} REUSE_FROM nf_design)
        endif()
    endif()
endfunction()

# nf_compile_together(<target>)
#
# Compiles the C++ sources of a library at once: most of the time goes into the headers that they share. So a name in
# an unnamed namespace has to be unique in its library. Sources that were given to nf_compile_alone() before stay alone.
function(nf_compile_together target)
    get_target_property(sources ${target} SOURCES)
    if(NOT sources MATCHES "[.]c(;|$)")
        set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
    endif()
endfunction()

# nf_compile_alone(<source>...)
#
# Sources that get a translation unit of their own. Give the reason at the call.
function(nf_compile_alone)
    set_source_files_properties(${ARGV} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# nf_add_floor(<target> SOURCES <file>... [SMALL <file>...] [LINK <target>...])
#
# SMALL: sources that an ordinary tick of RUN without a sensor does not run through. An image has them small, as its flash is nearly full.
#
# One floor: a static library whose folder is its public include folder.
# It sees the headers of the floors it links and no others, so an upward include
# does not compile.
function(nf_add_floor target)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;SMALL;LINK")
    add_library(${target} STATIC ${arg_SOURCES} ${arg_SMALL})
    if(CMAKE_SYSTEM_NAME STREQUAL "Generic")
        set_source_files_properties(${arg_SMALL} PROPERTIES COMPILE_OPTIONS -Os)
    endif()
    target_include_directories(${target} PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
    target_compile_features(${target} PUBLIC c_std_11)
    target_link_libraries(${target} PUBLIC ${arg_LINK} PRIVATE nf_warnings)
    nf_precompile(${target})
    nf_compile_together(${target})
    if(target MATCHES "^nf_(math|control|protect|drive_config|drive|record|app)$")
        nf_count(${target})
    else()
        nf_count(${target} FUNCTIONS_ONLY)
    endif()
endfunction()

# nf_add_program(<target> SOURCES <file>... [LINK <target>...])
#
# A program of the host; it lands at the top of the build folder.
function(nf_add_program target)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINK")
    add_executable(${target} ${arg_SOURCES})
    target_link_libraries(${target} PRIVATE ${arg_LINK} nf_warnings)
    nf_precompile(${target})
    set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
endfunction()
