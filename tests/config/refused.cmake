# SPDX-License-Identifier: MIT
# cmake -DLINE=<start> -P refused.cmake -- <program> <argument>...
# Fails unless the program exits with 2, says nothing on stdout and on stderr exactly one line that
# starts with LINE.
set(command "")
set(after_dashes OFF)
math(EXPR last "${CMAKE_ARGC} - 1")
foreach(index RANGE ${last})
    if(after_dashes)
        list(APPEND command "${CMAKE_ARGV${index}}")
    elseif(CMAKE_ARGV${index} STREQUAL "--")
        set(after_dashes ON)
    endif()
endforeach()

execute_process(COMMAND ${command}
    RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE error)
string(FIND "${error}" "${LINE}" start)
string(LENGTH "${error}" length)
string(FIND "${error}" "\n" line_end)
math(EXPR line_length "${line_end} + 1")
if(NOT code STREQUAL "2" OR NOT output STREQUAL "" OR NOT start EQUAL 0
        OR NOT line_length EQUAL length)
    message(FATAL_ERROR
        "exit code ${code}, expected 2\nstdout: ${output}\nstderr: ${error}\nexpected: ${LINE}…")
endif()
