# SPDX-License-Identifier: MIT
# nf_add_floor(<target> SOURCES <file>... [LINK <target>...])
#
# One floor of the house: a static library whose folder is its public include folder.
# It sees the headers of the floors it links and no others, so an upward include
# does not compile.
function(nf_add_floor target)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINK")
    add_library(${target} STATIC ${arg_SOURCES})
    target_include_directories(${target} PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
    target_compile_features(${target} PUBLIC c_std_11)
    target_link_libraries(${target} PUBLIC ${arg_LINK} PRIVATE nf_warnings)
    if(target MATCHES "^nf_(math|control|drive|app)$")
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
    set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
endfunction()
