# nf_add_floor(<target> SOURCES <file>... [LINK <target>...])
#
# One floor of the house: a static library whose folder is its public include folder.
# It sees the headers of the floors it links and no others, so an upward include
# does not compile.
function(nf_add_floor target)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINK")
    nf_written(sources ${arg_SOURCES})
    add_library(${target} STATIC ${sources})
    target_include_directories(${target} PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
    target_link_libraries(${target} PUBLIC ${arg_LINK} PRIVATE nf_warnings)
endfunction()

# nf_add_program(<target> SOURCES <file>... [LINK <target>...])
#
# A program of the host; it lands at the top of the build folder.
function(nf_add_program target)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINK")
    nf_written(sources ${arg_SOURCES})
    if(sources MATCHES "stub\\.c$")
        return()
    endif()
    add_executable(${target} ${sources})
    target_link_libraries(${target} PRIVATE ${arg_LINK} nf_warnings)
    set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})
endfunction()

# The listed files; with NF_DRAFT only those that exist, and a stub if there are none,
# so that one floor can be built while the next is still on paper.
function(nf_written result)
    set(files ${ARGN})
    if(NF_DRAFT)
        list(TRANSFORM files PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
        file(GLOB files ${files})
        if(NOT files)
            set(files ${CMAKE_CURRENT_BINARY_DIR}/stub.c)
            file(CONFIGURE OUTPUT stub.c CONTENT "typedef int nf_stub_t;\n")
        endif()
    endif()
    set(${result} ${files} PARENT_SCOPE)
endfunction()
