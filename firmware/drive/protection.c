#include "protection.h"

#include "fx.h"

/* The largest magnitude of the three phase currents. */
static int32_t largest_current(const protection_in_t *in)
{
    const int32_t a = in->phase_a;
    const int32_t b = in->phase_b;

    return fx_max(fx_max(fx_abs(a), fx_abs(b)), fx_abs(a + b));
}

fault_id_t protection_check(const protection_cfg_t *cfg, const protection_in_t *in)
{
    fault_id_t id = FAULT_NONE;

    if (in->break_input) {
        id = FAULT_BREAK;
    } else if (in->check_current && (largest_current(in) > cfg->current_max)) {
        id = FAULT_OVERCURRENT;
    } else if (in->bus > cfg->bus_max) {
        id = FAULT_OVERVOLTAGE;
    } else if (in->check_undervoltage && (in->bus < cfg->bus_min)) {
        id = FAULT_UNDERVOLTAGE;
    } else {
        /* nothing wrong */
    }
    return id;
}

fault_t protection_record(const protection_cfg_t *cfg, const protection_in_t *in, fault_id_t id)
{
    fault_t fault = {.id = id, .value = in->bus, .limit = cfg->bus_max};

    if ((id == FAULT_BREAK) || (id == FAULT_OVERCURRENT)) {
        fault.value = largest_current(in);
        fault.limit = cfg->current_max;
    } else if (id == FAULT_UNDERVOLTAGE) {
        fault.limit = cfg->bus_min;
    } else {
        /* over-voltage: as initialised */
    }
    return fault;
}

fault_t protection_check_offset(const protection_cfg_t *cfg, int32_t offset_a, int32_t offset_b)
{
    const int32_t worse = fx_max(fx_abs(offset_a), fx_abs(offset_b));

    return (fault_t){
        .id = (worse > cfg->offset_max) ? FAULT_CURRENT_OFFSET : FAULT_NONE,
        .value = worse,
        .limit = cfg->offset_max,
    };
}
