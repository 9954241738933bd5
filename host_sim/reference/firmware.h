/* SPDX-License-Identifier: MIT */
// The firmware's headers for C++.
#pragma once

extern "C" {
#include "drive.h"
}
