# SPDX-License-Identifier: MIT
# Toolchain file: bare Cortex-M with Debian's gcc-arm-none-eabi.
#
# NF_CPU, set by the preset, is a name that -mcpu knows. The whole core is integer arithmetic, so no
# image uses the FPU: the same object code model on all cores, and no FPU state to stack on interrupts.

set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR arm)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES NF_CPU)
# There is nothing yet that a whole program could be linked with.
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)

find_program(NF_ARM_GCC arm-none-eabi-gcc)
if(NOT NF_ARM_GCC)
    message(FATAL_ERROR "There is no arm-none-eabi-gcc. Run `tools/dev setup`.")
endif()
set(CMAKE_C_COMPILER ${NF_ARM_GCC})
# Archives of link-time optimisation need the compiler's own ar.
find_program(CMAKE_AR arm-none-eabi-gcc-ar REQUIRED)
find_program(CMAKE_RANLIB arm-none-eabi-gcc-ranlib REQUIRED)

# -fno-short-enums: an enum is as wide as on the PC, so a struct has the same members on both and
# the compiler warns about the same conversions.
string(JOIN " " CMAKE_C_FLAGS_INIT
    -mcpu=${NF_CPU} -mthumb -mfloat-abi=soft
    -ffreestanding -fno-short-enums -fno-common
    -ffunction-sections -fdata-sections -flto)
set(CMAKE_ASM_FLAGS_INIT "-mcpu=${NF_CPU} -mthumb")
set(CMAKE_C_FLAGS_RELWITHDEBINFO "-O2 -g" CACHE STRING "Flags of the one build type")

set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
