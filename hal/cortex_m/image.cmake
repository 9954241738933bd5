# SPDX-License-Identifier: MIT
# nf_add_image(<target> SCRIPT <linker script> SOURCES <file>... [LINK <target>...])
#
# Adds an image for a Cortex-M: <target>.elf and <target>.map at the top of the build folder.
# The start-up code is compiled in; the linker script may INCLUDE sections.ld.

# A library of its own, so that tools which read C do not see the assembly.
enable_language(ASM)
add_library(nf_safe_state OBJECT ${CMAKE_CURRENT_LIST_DIR}/safe_state.S)
set_target_properties(nf_safe_state PROPERTIES EXPORT_COMPILE_COMMANDS OFF)

function(nf_add_image target)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "SCRIPT" "SOURCES;LINK")
    set(here ${CMAKE_CURRENT_FUNCTION_LIST_DIR})
    set(script ${CMAKE_CURRENT_SOURCE_DIR}/${arg_SCRIPT})
    set(map ${PROJECT_BINARY_DIR}/${target}.map)
    add_executable(${target} ${arg_SOURCES} ${here}/reset.c)
    # If it were optimised together with main(), it could read variables before it has filled them.
    set_source_files_properties(${here}/reset.c PROPERTIES COMPILE_OPTIONS -fno-lto)
    target_include_directories(${target} PRIVATE ${here})
    target_link_libraries(${target} PRIVATE ${arg_LINK} nf_safe_state nf_warnings)
    # -fcallgraph-info writes the call graph <target>.elf.ltrans*.ltrans.ci: who calls whom, with how
    # much stack. It is an option of the link, because the link generates the code.
    #
    # Newlib was compiled with short enums. No part of it that is used here has an enum.
    target_link_options(${target} PRIVATE
        -nostartfiles --specs=nano.specs -T ${script} -L ${here}
        -fcallgraph-info=su
        -Wl,--gc-sections -Wl,--build-id=sha1 -Wl,--fatal-warnings -Wl,--no-enum-size-warning -Wl,-Map=${map})
    set_target_properties(${target} PROPERTIES
        SUFFIX .elf
        RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}
        LINK_DEPENDS "${script};${here}/sections.ld")
endfunction()
