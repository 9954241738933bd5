/* SPDX-License-Identifier: MIT */
/* Of a program of tests that has no main() of its own. */
#include "testing.h"

int main(int argc, char **argv)
{
    return testing_main(argc, argv);
}
