/* SPDX-License-Identifier: MIT */
#include "testing.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static registered_test_t *first;
static registered_test_t **end_of_list = &first;

__attribute__((weak)) void setUp(void)
{
}

__attribute__((weak)) void tearDown(void)
{
}

void testing_register(registered_test_t *test)
{
    *end_of_list = test;
    end_of_list = &test->next;
}

bool testing_has_many_runs(void)
{
    const char *const asked = getenv("NF_MANY_RUNS");

    return (asked != NULL) && ((strcmp(asked, "1") == 0) || (strcmp(asked, "whole") == 0));
}

unsigned testing_runs(unsigned few, unsigned many)
{
    return testing_has_many_runs() ? many : few;
}

static const registered_test_t *find(const char *name)
{
    const registered_test_t *test = first;

    while ((test != NULL) && (strcmp(test->name, name) != 0)) {
        test = test->next;
    }
    return test;
}

static void run(const registered_test_t *test)
{
    UnitySetTestFile(test->file);
    UnityDefaultTestRun(test->run, test->name, test->line);
}

int testing_main(int argc, char **argv)
{
    for (int at = 1; at < argc; at++) {
        if (find(argv[at]) == NULL) {
            fprintf(stderr, "%s: found '%s'; allowed: names of its tests:\n", argv[0], argv[at]);
            for (const registered_test_t *test = first; test != NULL; test = test->next) {
                fprintf(stderr, "  %s\n", test->name);
            }
            return 2;
        }
    }
    UnityBegin((first != NULL) ? first->file : argv[0]);
    for (int at = 1; at < argc; at++) {
        run(find(argv[at]));
    }
    for (const registered_test_t *test = (argc > 1) ? NULL : first; test != NULL;
         test = test->next) {
        run(test);
    }
    return UnityEnd();
}
