# SPDX-License-Identifier: MIT
# The drive once more, of the same sources: its calls of a control module's function f go to seam_f (seams.cpp), its
# drive_step() is called instrumented_drive_step(), and all else of it is local to one object file.
set(seams
    trig_sincos transforms_clarke transforms_park transforms_park_inverse nn_observer_predict nn_observer_train
    rotor_position_step position_loop_step speed_loop_ramp speed_loop_accelerate speed_loop_step pi_step
    phase_compensator_step current_loop_plan current_loop_model current_loop_step modulator_track_bus modulator_limit
    modulator_ratio modulator_compare modulator_compare_compensated torque_filter_step
    virtual_resistance_step)

# Read before each source. The modules' headers come first: they define what they define by its own name.
set(text "/* SPDX-License-Identifier: MIT */\n")
foreach(module IN ITEMS current_loop modulator motion_loop nn_observer phase_compensator rotor_position torque_filter
        virtual_resistance)
    string(APPEND text "#include \"${module}.h\"\n")
endforeach()
foreach(seam IN LISTS seams)
    string(APPEND text "extern __typeof__(${seam}) *const seam_${seam};\n#define ${seam} seam_${seam}\n")
endforeach()
string(APPEND text "#define drive_step instrumented_drive_step\n")
set(redirect ${CMAKE_CURRENT_BINARY_DIR}/redirect.h)
file(GENERATE OUTPUT ${redirect} CONTENT "${text}")

get_target_property(sources nf_drive SOURCES)
get_target_property(folder nf_drive SOURCE_DIR)
list(TRANSFORM sources PREPEND ${folder}/)
add_library(nf_instrumented OBJECT ${sources})
target_link_libraries(nf_instrumented PRIVATE nf_drive)
# Without debug information gdb finds each function of the drive once.
target_compile_options(nf_instrumented PRIVATE -g0 -fno-sanitize=all "SHELL:-include ${redirect}")
set_target_properties(nf_instrumented PROPERTIES EXPORT_COMPILE_COMMANDS OFF)

if(EMSCRIPTEN)
    # A WebAssembly object keeps its global names: they are renamed before they are compiled.
    set(renamed ${CMAKE_CURRENT_BINARY_DIR}/renamed.h)
    add_custom_command(OUTPUT ${renamed}
        COMMAND ${CMAKE_COMMAND} -DNM=${CMAKE_NM} -DHEADER=${renamed} "-DOBJECTS=$<TARGET_OBJECTS:nf_drive>"
            -P ${CMAKE_CURRENT_LIST_DIR}/renamed.cmake
        DEPENDS $<TARGET_OBJECTS:nf_drive> ${CMAKE_CURRENT_LIST_DIR}/renamed.cmake
        VERBATIM)
    set_source_files_properties(${sources} PROPERTIES OBJECT_DEPENDS ${renamed})
    target_compile_options(nf_instrumented PRIVATE "SHELL:-include ${renamed}")
    set(instrumented $<TARGET_OBJECTS:nf_instrumented>)
    return()
endif()

set(instrumented ${CMAKE_CURRENT_BINARY_DIR}/instrumented.o)
add_custom_command(OUTPUT ${instrumented}
    COMMAND ${CMAKE_LINKER} -r -o ${instrumented} $<TARGET_OBJECTS:nf_instrumented>
    COMMAND ${CMAKE_OBJCOPY} --keep-global-symbol=instrumented_drive_step ${instrumented}
    DEPENDS $<TARGET_OBJECTS:nf_instrumented>
    COMMAND_EXPAND_LISTS VERBATIM)
