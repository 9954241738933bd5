# SPDX-License-Identifier: MIT
# Writes HEADER, which gives another name to each function and variable that OBJECTS define for others; NM lists them.
# drive_step() has its new name already.
execute_process(COMMAND ${NM} --defined-only --extern-only --format=posix ${OBJECTS}
    OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[A-Za-z_][A-Za-z0-9_]* [TDBRV] " names "${listed}")
set(text "/* SPDX-License-Identifier: MIT */\n")
foreach(name IN LISTS names)
    string(REGEX REPLACE " .*" "" name "${name}")
    if(NOT name STREQUAL "drive_step")
        string(APPEND text "#define ${name} instrumented_${name}\n")
    endif()
endforeach()
file(WRITE ${HEADER} "${text}")
