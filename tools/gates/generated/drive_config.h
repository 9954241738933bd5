/* SPDX-License-Identifier: MIT */
/* Stands for what nfconfig makes of a board's files: gate.misra reads the sources without a build. */
#ifndef DRIVE_CONFIG_H
#define DRIVE_CONFIG_H

#define DRIVE_RECORDER_ENTRIES (352U)
#define DRIVE_POLE_PAIRS (7U)
#define DRIVE_TICK_PS (50000000U)

#endif
