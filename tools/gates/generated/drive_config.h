/* SPDX-License-Identifier: MIT */
/*
 * Stands for what nfconfig makes of a board's files: gate.misra reads the sources without a build.
 */
#ifndef DRIVE_CONFIG_H
#define DRIVE_CONFIG_H

#define DRIVE_RECORDER_ENTRIES (352U)

#define DRIVE_ABOUT \
    .name = "neurofoc: a motor, a board, a tuning", \
    .rotation = {.pole_pairs = 7U, .tick_ps = 50000000U}, .speed_max_rpm = 3000, \
    .current_zero_count = 2048U, .current_full_scale_ua = 60200000U, \
    .bus_full_scale_uv = 34280000U, \
    .temperature = {.points = 2U, .at = {[0] = {0, 0}, [1] = {4096, 100000}}}

#endif
