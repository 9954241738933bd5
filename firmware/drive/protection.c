#include "protection.h"

#include "fx.h"

static fault_t make_fault(fault_id_t id, int32_t value, int16_t limit)
{
    return (fault_t){.id = id, .value = fx_sat16(value), .limit = limit};
}

/* The largest magnitude of the three phase currents. */
static int32_t largest_current(const protection_in_t *in)
{
    const int32_t a = in->phase_a;
    const int32_t b = in->phase_b;

    return fx_max(fx_max(fx_abs(a), fx_abs(b)), fx_abs(a + b));
}

fault_t protection_check(const protection_cfg_t *cfg, const protection_in_t *in)
{
    const int32_t current = largest_current(in);
    fault_t fault = {.id = FAULT_NONE};

    if (in->break_input) {
        fault = make_fault(FAULT_BREAK, current, cfg->current_max);
    } else if (in->check_current && (current > cfg->current_max)) {
        fault = make_fault(FAULT_OVERCURRENT, current, cfg->current_max);
    } else if (in->bus > cfg->bus_max) {
        fault = make_fault(FAULT_OVERVOLTAGE, in->bus, cfg->bus_max);
    } else if (in->check_undervoltage && (in->bus < cfg->bus_min)) {
        fault = make_fault(FAULT_UNDERVOLTAGE, in->bus, cfg->bus_min);
    } else {
        /* nothing wrong */
    }
    return fault;
}

fault_t protection_check_offset(const protection_cfg_t *cfg, int32_t offset_a, int32_t offset_b)
{
    const int32_t worse = fx_max(fx_abs(offset_a), fx_abs(offset_b));
    fault_t fault = {.id = FAULT_NONE};

    if (worse > cfg->offset_max) {
        fault = make_fault(FAULT_CURRENT_OFFSET, worse, cfg->offset_max);
    }
    return fault;
}
