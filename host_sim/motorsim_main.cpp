// SPDX-License-Identifier: MIT
#include "motorsim.h"

int main(int argc, char **argv)
{
    return nf::motorsim(argc, argv);
}
