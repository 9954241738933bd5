/* SPDX-License-Identifier: MIT */
/*
 * Linked to a test whose module holds all of its mutants: which one runs, and for how long. See
 * schemata.py.
 */
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>

int nf_mutant;

static long number(const char *name)
{
    const char *const text = getenv(name);

    return (text != NULL) ? strtol(text, NULL, 10) : 0;
}

__attribute__((constructor)) static void choose(void)
{
    const rlim_t seconds = (rlim_t)number("NF_SECONDS");

    nf_mutant = (int)number("NF_MUTANT");
    if (seconds > 0) {
        (void)setrlimit(RLIMIT_CPU, &(struct rlimit){seconds, seconds});
    }
    /* Line by line: mutation.py stops at the first FAIL. */
    (void)setvbuf(stdout, NULL, _IOLBF, BUFSIZ);
}
