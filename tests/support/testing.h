/* SPDX-License-Identifier: MIT */
/*
 * A test of a Unity program, C or C++:
 *
 *     TEST(what_must_hold)
 *     {
 *         TEST_ASSERT_TRUE(...);
 *     }
 *
 * A program of tests needs no main(), no setUp() and no tearDown().
 */
#ifndef TESTING_H
#define TESTING_H

#include <stdbool.h>
#include <stddef.h>
#include <unity.h>

#ifdef __cplusplus
/*
 * Unity's macros of these names would spoil the headers that come after it; only unity.c needs
 * them.
 */
#undef isinf
#undef isnan
extern "C" {
#endif

typedef struct registered_test {
    void (*run)(void);
    const char *name;
    const char *file;
    int line;
    struct registered_test *next;
} registered_test_t;

/* Appends a test to the list of its program. Only TEST() calls it, before main() begins. */
void testing_register(registered_test_t *test);

/*
 * Runs all tests in the order of their file, or those alone that the command line names. Returns
 * the exit status: 0, the number of tests that failed, or 2 if a name is unknown: then a line on
 * stderr says which are allowed. A program without a main() of its own calls only this.
 */
int testing_main(int argc, char **argv);

/*
 * Whether a test that repeats a run does it often: not in `tools/dev test`, but in the evidence,
 * which sets NF_MANY_RUNS=1.
 */
bool testing_has_many_runs(void);

/* The number of runs, or of seconds of one: `many` where testing_has_many_runs(), else `few`. */
unsigned testing_runs(unsigned few, unsigned many);

#ifdef __cplusplus
}
#endif

#define TEST(name) \
    static void name(void); \
    __attribute__((constructor)) static void register_##name(void) \
    { \
        static registered_test_t registered = {name, #name, __FILE__, __LINE__, NULL}; \
        testing_register(&registered); \
    } \
    static void name(void)

#endif
