/* SPDX-License-Identifier: MIT */
/*
 * In the build with counters: what each Unity test runs alone. --wrap puts this in the place of
 * Unity's own runner. The counts of a test go to <title>.<test>.profraw beside <title>.%p.profraw,
 * the file that LLVM_PROFILE_FILE names. Where it names no such file, as by hand, all tests are
 * counted together.
 */
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PATH_BYTES (4096)

/* Of the compiler's profile library. */
void __llvm_profile_reset_counters(void);
int __llvm_profile_write_file(void);
void __llvm_profile_set_filename(const char *name);

void __real_UnityDefaultTestRun(UnityTestFunction function, const char *name, int line);
void __wrap_UnityDefaultTestRun(UnityTestFunction function, const char *name, int line);

static void leave_counts(const char *of_program, const char *name)
{
    const char *const process = strstr(of_program, "%p");
    char path[PATH_BYTES];

    if (snprintf(path, sizeof path, "%.*s%s.profraw", (int)(process - of_program), of_program,
                 name) >= (int)sizeof path) {
        abort();
    }
    __llvm_profile_set_filename(path);
    if (__llvm_profile_write_file() != 0) {
        abort();
    }
    __llvm_profile_set_filename(of_program);
}

void __wrap_UnityDefaultTestRun(UnityTestFunction function, const char *name, int line)
{
    const char *const of_program = getenv("LLVM_PROFILE_FILE");

    if ((of_program == NULL) || (strstr(of_program, "%p") == NULL)) {
        __real_UnityDefaultTestRun(function, name, line);
        return;
    }
    __llvm_profile_reset_counters();
    __real_UnityDefaultTestRun(function, name, line);
    leave_counts(of_program, name);
    __llvm_profile_reset_counters();
}
