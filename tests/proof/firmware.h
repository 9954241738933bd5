/* SPDX-License-Identifier: MIT */
/* All of the firmware below the HAL as one unit, so that its inline functions are there once. */
#include "../../firmware/control/current_loop.c"
#include "../../firmware/control/modulator.c"
#include "../../firmware/control/motion_loop.c"
#include "../../firmware/math/trig.c"
#include "../../firmware/math/trig_table.c"
#undef DISTANCE_MAX /* motion_loop.c and derating.c have one each */
#include "../../firmware/config/config_check.c"
#include "../../firmware/control/align.c"
#include "../../firmware/control/angle_sensor.c"
#include "../../firmware/control/flying_start.c"
#include "../../firmware/control/nn_observer.c"
#include "../../firmware/control/phase_compensator.c"
#include "../../firmware/control/pi.c"
#include "../../firmware/control/transforms.c"
#include "../../firmware/control/virtual_resistance.c"
#undef CFG
#undef CFG_STARTUP
#undef CFG_BOTH
#undef CFG_VOLTAGE
#include "../../firmware/config/config_guard.c"
#include "../../firmware/control/model.c"
#include "../../firmware/drive/drive.c"
#include "../../firmware/drive/estimate.c"
#include "../../firmware/drive/frame.c"
#include "../../firmware/drive/monitor.c"
#include "../../firmware/drive/open_loop.c"
#include "../../firmware/drive/run.c"
#include "../../firmware/drive/schedule.c"
#include "../../firmware/drive/straight.c"
#include "../../firmware/drive/transitions.c"
#include "../../firmware/drive/voltage_drive.c"
#include "../../firmware/math/crc32.c"
#include "../../firmware/protect/derating.c"
#include "../../firmware/protect/oscillation.c"
#include "../../firmware/protect/protection.c"
#include "../../firmware/protect/supervision.c"
