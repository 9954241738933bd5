/* SPDX-License-Identifier: MIT */
/* The input frame of a tick, free in its whole raw range; for Eva. */
#ifndef ANY_FRAME_H
#define ANY_FRAME_H

#include "drive.h"

#include <__fc_builtin.h>

static drive_in_t any_frame(void)
{
    drive_in_t in = {0};

    in.adc_ia = Frama_C_unsigned_short_interval(0, 65535);
    in.adc_ib = Frama_C_unsigned_short_interval(0, 65535);
    in.adc_bus = Frama_C_unsigned_short_interval(0, 65535);
    in.adc_temperature = Frama_C_unsigned_short_interval(0, 65535);
    in.flags = Frama_C_unsigned_short_interval(0, 65535);
    in.angle = Frama_C_unsigned_short_interval(0, 65535);
    in.command.target = Frama_C_interval(INT32_MIN, INT32_MAX);
    in.command.mode = Frama_C_unsigned_char_interval(0, 255);
    in.command.request = Frama_C_unsigned_char_interval(0, 255);
    return in;
}

#endif
