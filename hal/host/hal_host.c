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

static uint16_t read_channel(const hal_host_channel_t *channel, uint16_t count)
{
    return channel->forced ? channel->count : count;
}

void hal_sample(hal_t *hal, drive_in_t *in)
{
    const hal_host_faults_t *const faults = &hal->faults;
    const uint32_t late = hal->late ? DRIVE_FLAG_LATE : 0U;
    const bool tripped = plant_take_trip(hal->plant);
    const uint32_t broken = (faults->broken || tripped) ? DRIVE_FLAG_BREAK : 0U;
    plant_adc_t adc;

    plant_sample(hal->plant, &adc);
    in->adc_ia = read_channel(&faults->ia, adc.ia);
    in->adc_ib = read_channel(&faults->ib, adc.ib);
    in->adc_bus = read_channel(&faults->bus, adc.bus);
    in->adc_temperature = read_channel(&faults->temperature, adc.temperature);
    in->angle = read_channel(&faults->angle, adc.angle);
    in->flags = (uint16_t)(late | broken);
}

void hal_apply(hal_t *hal, const drive_out_t *out)
{
    const bool late = hal->faults.late;
    const uint32_t rest = hal->plant->inverter.timer_counts / 2U;
    const uint32_t compare[PLANT_LEGS] = {
        late ? rest : out->compare.phase[0],
        late ? rest : out->compare.phase[1],
        late ? rest : out->compare.phase[2],
    };

    hal->late = late;
    plant_write_compare(hal->plant, compare);
    plant_set_gates(hal->plant, out->gate_enable && !hal->faults.broken);
}

void hal_open_gates(hal_t *hal)
{
    plant_set_gates(hal->plant, false);
}

uint32_t hal_ticks(const hal_t *hal)
{
    return hal->ticks;
}
