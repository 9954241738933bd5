# SPDX-License-Identifier: MIT
# Motor, board and tuning of an image: names of files in host_sim/, or paths of the user's own files.
#
# A reference with a '/' or ending in .toml is a path; any other is the name of a file in host_sim/. nfconfig follows the
# same rule and reports what is wrong with a reference.
#
# All functions may be called from another project, which does not see the variables of this one.

set(help "The host's nfconfig, which writes the configuration of an image")
if(PROJECT_IS_TOP_LEVEL)
    set(default nfconfig) # the target
    if(CMAKE_CROSSCOMPILING)
        set(default ${PROJECT_SOURCE_DIR}/build/host/nfconfig)
    endif()
endif()
if(PROJECT_IS_TOP_LEVEL OR DEFINED CACHE{NF_NFCONFIG})
    # The type makes a relative path of the command line absolute, and leaves the target's name.
    set(NF_NFCONFIG "${default}" CACHE FILEPATH "${help}")
else()
    # The nfconfig of the installed package, else the one built in these sources, else the one on the PATH.
    find_program(NF_NFCONFIG nfconfig NO_CACHE NO_CMAKE_FIND_ROOT_PATH
        HINTS ${PROJECT_SOURCE_DIR}/../../bin ${PROJECT_SOURCE_DIR}/build/host)
endif()
set_property(GLOBAL PROPERTY NF_NFCONFIG "${NF_NFCONFIG}")

# Whether a reference is a path.
function(nf_is_path result reference)
    set(${result} FALSE PARENT_SCOPE)
    if(reference MATCHES "/|\\.toml$")
        set(${result} TRUE PARENT_SCOPE)
    endif()
endfunction()

# nf_choice(<name> <default> <help>)
#
# The value that the user gives with -D<name>=... If it is a path, it is relative to the folder in which he calls cmake.
function(nf_choice name default help)
    nf_is_path(is_path "$CACHE{${name}}")
    if(is_path)
        set(${name} ${default} CACHE FILEPATH "${help}") # the type makes an untyped path absolute
    else()
        set(${name} ${default} CACHE STRING "${help}")
    endif()
endfunction()

# The file of a reference. A path in a CMakeLists.txt is relative to its folder.
function(nf_data_file file folder reference)
    nf_is_path(is_path "${reference}")
    if(is_path)
        cmake_path(ABSOLUTE_PATH reference OUTPUT_VARIABLE path)
    else()
        set(path ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/../host_sim/${folder}/${reference}.toml)
        cmake_path(NORMAL_PATH path)
    endif()
    set(${file} ${path} PARENT_SCOPE)
endfunction()

# Appends the arguments for nfconfig to `arguments`, and the file to `files`. If there is no such file, nfconfig itself
# says so and lists the names.
macro(nf_refer option folder reference)
    nf_data_file(file ${folder} "${reference}")
    nf_is_path(is_path "${reference}")
    if(is_path)
        list(APPEND arguments ${option} ${file})
    else()
        list(APPEND arguments ${option} ${reference})
    endif()
    if(EXISTS ${file})
        list(APPEND files ${file})
    endif()
endmacro()

# Lets <target> include <output>, which nfconfig <command> writes.
function(nf_config_file target output command)
    cmake_parse_arguments(PARSE_ARGV 3 arg "" "MOTOR;BOARD;TUNING" "WITH")
    get_property(nfconfig GLOBAL PROPERTY NF_NFCONFIG)
    if(NOT nfconfig OR (IS_ABSOLUTE ${nfconfig} AND NOT EXISTS ${nfconfig}))
        string(REGEX REPLACE ".*-NOTFOUND$" "nfconfig" nfconfig "${nfconfig}")
        message(FATAL_ERROR
            "There is no ${nfconfig}.\n"
            "Run `tools/dev build` in the sources of neurofoc first, or give the path with -DNF_NFCONFIG=FILE.")
    endif()
    set(arguments)
    set(files)
    nf_refer(--motor motors ${arg_MOTOR})
    nf_refer(--board boards ${arg_BOARD})
    nf_refer(--tuning tunings ${arg_TUNING})
    foreach(with IN LISTS arg_WITH)
        nf_refer(--with imperfections ${with})
    endforeach()
    set(folder ${CMAKE_CURRENT_BINARY_DIR}/${target}_config)
    file(MAKE_DIRECTORY ${folder})
    add_custom_command(OUTPUT ${folder}/${output}
        COMMAND ${nfconfig} ${command} ${arguments} --out ${folder}/${output}
        DEPENDS ${nfconfig} ${files}
        COMMENT "${output} of ${target}: ${arg_MOTOR}, ${arg_BOARD}, ${arg_TUNING}"
        VERBATIM)
    target_sources(${target} PRIVATE ${folder}/${output})
    target_include_directories(${target} PRIVATE ${folder})
endfunction()

# nf_report_alike(<target> MOTOR <file> BOARD <file> TUNING <file>)
#
# At its end the build of <target> says how many random motors like this one the tuning holds. They are simulated again
# when one of the files has changed.
function(nf_report_alike target)
    nf_config_file(${target} alike.txt alike ${ARGN})
    add_custom_command(TARGET ${target} POST_BUILD
        COMMAND ${CMAKE_COMMAND} -E cat ${CMAKE_CURRENT_BINARY_DIR}/${target}_config/alike.txt
        VERBATIM)
endfunction()

# nf_drive_config(<target> MOTOR <file> BOARD <file> TUNING <file> [WITH <imperfection set>...])
#
# Lets <target> include drive_config.h, the drive's configuration.
function(nf_drive_config target)
    nf_config_file(${target} drive_config.h header ${ARGN})
endfunction()

# nf_hal_config(<target> MOTOR <file> BOARD <file> TUNING <file>)
#
# Lets <target> include hal_config.h, the numbers of the board that a binding needs.
function(nf_hal_config target)
    nf_config_file(${target} hal_config.h hal-header ${ARGN})
endfunction()

# nf_hal_memory(<target> MOTOR <file> BOARD <file> TUNING <file>)
#
# Lets the linker script of <target> include hal_memory.ld, the memories of the board's chip.
function(nf_hal_memory target)
    nf_config_file(${target} hal_memory.ld hal-memory ${ARGN})
    target_link_options(${target} PRIVATE -L${CMAKE_CURRENT_BINARY_DIR}/${target}_config)
    set_property(TARGET ${target} APPEND PROPERTY
        LINK_DEPENDS ${CMAKE_CURRENT_BINARY_DIR}/${target}_config/hal_memory.ld)
endfunction()
