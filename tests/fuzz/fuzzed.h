/* SPDX-License-Identifier: MIT */
/* What libFuzzer calls, and how a program says that something does not hold. */
#ifndef FUZZED_H
#define FUZZED_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef __cplusplus
extern "C"
#endif
    int
    LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define HOLDS(condition, what) \
    do { \
        if (!(condition)) { \
            (void)fprintf(stderr, "%s:%d: does not hold: %s\n", __FILE__, __LINE__, what); \
            abort(); \
        } \
    } while (0)

#endif
