/* SPDX-License-Identifier: MIT */
/*
 * Protection: the limits of a single sample. A sample beyond a limit opens the gates at once.
 *
 * The drive checks each sample before it controls. It latches a fault and opens the gates in the
 * same tick. Pure. Currents Q15 of I_b, bus Q15 of U_b.
 */
#ifndef PROTECTION_H
#define PROTECTION_H

#include "fault.h"
#include "fx.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int32_t current_max; /* over-current: limit of |phase current|, Q15 of I_b, 1…16382 */
    int32_t bus_max;     /* over-voltage: limit of the bus, Q15 of U_b, 1…32766 */
    int32_t bus_min;
    int32_t offset_max; /* limit of |sensor offset|, Q15 of I_b */
} protection_cfg_t;

/*
 * The limits in force. Each is the configured limit or, while its check is off, a limit that no
 * sample reaches (protection_limits()).
 */
typedef struct {
    int32_t current_max;
    int32_t bus_max;
    int32_t bus_min;
} protection_limits_t;

/* The samples of one instant, per unit, corrected by the offsets. */
typedef struct {
    int32_t phase_a; /* −16384…16383 */
    int32_t phase_b;
    int32_t bus; /* 0…32767 */
} sample_t;

/*
 * Returns the limits in force. Over-voltage is always checked; currents and under-voltage only
 * while the drive runs.
 */
protection_limits_t protection_limits(const protection_cfg_t *cfg, bool running);

/*
 * Returns BREAK, the fault of a power stage that has opened its gates by itself. The value is the
 * largest phase current of this tick.
 */
fault_t protection_break(const sample_t *in);

/*
 * Whether |x| > limit, limit 0…65536, in one comparison: x + limit is above 2·limit if x > limit,
 * and wraps to a large unsigned number if x < −limit. Pure.
 */
static inline bool protection_exceeds(int32_t x, int32_t limit)
{
    return (fx_unsigned(x) + (uint32_t)limit) > (2U * (uint32_t)limit);
}

/* Whether protection_check() would find no fault. */
static inline bool protection_holds(const protection_limits_t *limits, sample_t in)
{
    return !protection_exceeds(in.phase_a, limits->current_max) &&
           !protection_exceeds(in.phase_b, limits->current_max) &&
           !protection_exceeds(in.phase_a + in.phase_b, limits->current_max) &&
           (in.bus <= limits->bus_max) && (in.bus >= limits->bus_min);
}

/* Returns the first fault in the order of fault_id_t. Phase c is −a − b. */
fault_id_t protection_check(const protection_limits_t *limits, const sample_t *in, fault_t *fault);

/*
 * Whether a raw count is at an end of the range of its converter. shift: 15 − bits, as in
 * sampling_cfg_t. config_check ensures that such a sample is an over-current too. The drive then
 * names the fault FAULT_ADC_SATURATED.
 */
bool protection_saturated(uint16_t count, uint32_t shift);

/* Checks the offsets of both sensors from mid-scale after the calibration. */
fault_id_t protection_check_offset(const protection_cfg_t *cfg, int32_t offset_a, int32_t offset_b,
                                   fault_t *fault);

#endif
