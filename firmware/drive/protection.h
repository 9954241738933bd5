/* SPDX-License-Identifier: MIT */
/*
 * Protection: which measurement means that the gates must open now.
 *
 * Called each control tick before anything else is computed; a fault is latched by the drive and the
 * gates open in the same tick. Pure. Currents Q15 of I_b, bus Q15 of U_b.
 */
#ifndef PROTECTION_H
#define PROTECTION_H

#include "fault.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int32_t current_max; /* |phase current|, Q15 of I_b, 1…16382 */
    int32_t bus_max;     /* Q15 of U_b, 1…32766 */
    int32_t bus_min;
    int32_t offset_max; /* |sensor offset|, Q15 of I_b */
} protection_cfg_t;

/* The limits in force: those of the configuration, or out of reach while a measurement means nothing. */
typedef struct {
    int32_t current_max;
    int32_t bus_max;
    int32_t bus_min;
} protection_limits_t;

/* What is watched in this tick. */
typedef struct {
    int32_t phase_a; /* −16384…16383 */
    int32_t phase_b;
    int32_t bus; /* 0…32767 */
    bool break_input;
} protection_in_t;

/* Too high a bus is watched always, the currents and too low a bus while the drive runs. */
protection_limits_t protection_limits(const protection_cfg_t *cfg, bool running);

/* The first fault in the order of fault_id_t, or FAULT_NONE. Phase c is −a − b. */
fault_id_t protection_check(const protection_limits_t *limits, const protection_in_t *in);

/* The record of a fault that protection_check found, or ADC_SATURATED: measured value and limit; its tick is left 0. */
fault_t protection_record(const protection_limits_t *limits, const protection_in_t *in,
                          fault_id_t id);

/*
 * Whether a raw count, to be shifted left by `shift`, is at an end of its converter. params_check sees
 * to it that such a sample is an over-current too; it is then named FAULT_ADC_SATURATED.
 */
bool protection_saturated(uint16_t count, uint32_t shift);

/* Offsets of both sensors from mid-scale, after calibration: the record, or id FAULT_NONE. */
fault_t protection_check_offset(const protection_cfg_t *cfg, int32_t offset_a, int32_t offset_b);

#endif
