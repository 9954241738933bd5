/* SPDX-License-Identifier: MIT */
#include "protection.h"

#include "fx.h"

#define Q15_ONE (0x8000U)
#define NEVER (65536) /* above every |current|: −a − b is at most 32768 */

protection_limits_t protection_limits(const protection_cfg_t *cfg, bool running)
{
    return (protection_limits_t){
        .current_max = running ? cfg->current_max : NEVER,
        .bus_max = cfg->bus_max,
        .bus_min = running ? cfg->bus_min : 0,
    };
}

static fault_id_t first_fault(const protection_limits_t *limits, const sample_t *in)
{
    const int32_t a = in->phase_a;
    const int32_t b = in->phase_b;
    const int32_t max = limits->current_max;
    fault_id_t id = FAULT_NONE;

    if (protection_exceeds(a, max) || protection_exceeds(b, max) ||
        protection_exceeds(a + b, max)) {
        id = FAULT_OVERCURRENT;
    } else if (in->bus > limits->bus_max) {
        id = FAULT_OVERVOLTAGE;
    } else if (in->bus < limits->bus_min) {
        id = FAULT_UNDERVOLTAGE;
    } else {
        /* nothing wrong */
    }
    return id;
}

/* Returns the largest magnitude of the three phase currents. */
static int32_t largest_current(const sample_t *in)
{
    const int32_t a = in->phase_a;
    const int32_t b = in->phase_b;

    return fx_max(fx_max(fx_abs(a), fx_abs(b)), fx_abs(a + b));
}

static fault_t measured_fault(const protection_limits_t *limits, const sample_t *in, fault_id_t id)
{
    fault_t fault = {.id = id, .value = in->bus, .limit = limits->bus_max};

    if (id == FAULT_OVERCURRENT) {
        fault.value = largest_current(in);
        fault.limit = limits->current_max;
    } else if (id == FAULT_UNDERVOLTAGE) {
        fault.limit = limits->bus_min;
    } else {
        /* over-voltage: as initialised */
    }
    return fault;
}

fault_id_t protection_check(const protection_limits_t *limits, const sample_t *in, fault_t *fault)
{
    const fault_id_t id = first_fault(limits, in);

    if (id != FAULT_NONE) {
        *fault = measured_fault(limits, in, id);
    }
    return id;
}

fault_t protection_break(const sample_t *in)
{
    return (fault_t){.id = FAULT_BREAK, .value = largest_current(in), .limit = 0};
}

bool protection_saturated(uint16_t count, uint32_t shift)
{
    const uint32_t largest = (Q15_ONE >> shift) - 1U;

    return (count == 0U) || (count >= largest);
}

fault_id_t protection_check_offset(const protection_cfg_t *cfg, int32_t offset_a, int32_t offset_b,
                                   fault_t *fault)
{
    const int32_t worse = fx_max(fx_abs(offset_a), fx_abs(offset_b));
    fault_id_t id = FAULT_NONE;

    if (worse > cfg->offset_max) {
        id = FAULT_CURRENT_OFFSET;
        *fault = (fault_t){.id = id, .value = worse, .limit = cfg->offset_max};
    }
    return id;
}
