#include "hal_host.h"

void hal_host_init(hal_t *hal, plant_t *plant)
{
    *hal = (hal_t){.plant = plant, .ticks = 0U};
}

void hal_host_step(hal_t *hal)
{
    plant_step(hal->plant);
    hal->ticks++;
}

void hal_sample(hal_t *hal, drive_in_t *in)
{
    plant_adc_t adc;

    plant_sample(hal->plant, &adc);
    in->adc_ia = adc.ia;
    in->adc_ib = adc.ib;
    in->adc_bus = adc.bus;
    in->adc_temperature = adc.temperature;
    in->flags = 0U;
}

void hal_apply(hal_t *hal, const drive_out_t *out)
{
    const uint32_t compare[PLANT_LEGS] = {
        out->compare.phase[0],
        out->compare.phase[1],
        out->compare.phase[2],
    };

    plant_write_compare(hal->plant, compare);
    plant_set_gates(hal->plant, out->gate_enable);
}

void hal_open_gates(hal_t *hal)
{
    plant_set_gates(hal->plant, false);
}

uint32_t hal_ticks(const hal_t *hal)
{
    return hal->ticks;
}
