/* SPDX-License-Identifier: MIT */
#include "hal_host.h"

#include <stddef.h>

void hal_host_init(hal_t *hal, plant_t *plant)
{
    *hal = (hal_t){.plant = plant, .ticks = 0U};
}

void hal_host_step(hal_t *hal)
{
    if (hal->plant != NULL) {
        plant_step(hal->plant);
    }
    if (hal->line != NULL) {
        hal_host_line_step(hal->line);
    }
    if (hal->inputs != NULL) {
        hal_host_inputs_step(hal->inputs);
    }
    hal->ticks++;
}

void hal_host_feed(hal_t *hal, const drive_in_t *in)
{
    hal->fed = *in;
}

static uint16_t read_channel(const hal_host_channel_t *channel, uint16_t count)
{
    return channel->forced ? channel->count : count;
}

/* Takes the measurements of the power stage. */
static void measure(hal_t *hal, drive_in_t *in)
{
    plant_adc_t adc;

    plant_sample(hal->plant, &adc);
    in->adc_ia = adc.ia;
    in->adc_ib = adc.ib;
    in->adc_bus = adc.bus;
    hal->seen_ic = adc.ic;
    in->adc_temperature = adc.temperature;
    in->angle = adc.angle;
    in->flags = plant_take_trip(hal->plant) ? DRIVE_FLAG_BREAK : 0U;
}

void hal_sample(hal_t *hal, drive_in_t *in)
{
    const hal_host_faults_t *const faults = &hal->faults;
    const uint32_t late = hal->late ? DRIVE_FLAG_LATE : 0U;
    const uint32_t broken = faults->broken ? DRIVE_FLAG_BREAK : 0U;

    in->adc_ia = hal->fed.adc_ia;
    in->adc_ib = hal->fed.adc_ib;
    in->adc_bus = hal->fed.adc_bus;
    in->flags = hal->fed.flags;
    in->adc_temperature = hal->fed.adc_temperature;
    in->angle = hal->fed.angle;
    if (hal->plant != NULL) {
        measure(hal, in);
    }
    in->adc_ia = read_channel(&faults->ia, in->adc_ia);
    in->adc_ib = read_channel(&faults->ib, in->adc_ib);
    in->adc_bus = read_channel(&faults->bus, in->adc_bus);
    in->adc_temperature = read_channel(&faults->temperature, in->adc_temperature);
    in->angle = read_channel(&faults->angle, (uint16_t)(in->angle + faults->angle_offset));
    in->flags = (uint16_t)(in->flags | late | broken);
    hal->seen_ia = in->adc_ia;
    hal->seen_ib = in->adc_ib;
}

/* Reads the sensor of the plant, as its wires leave it. */
static hal_shaft_t read_plant(hal_t *hal)
{
    const hal_host_faults_t *const faults = &hal->faults;
    const plant_shaft_reading_t read = plant_read_shaft(hal->plant);
    const uint32_t slipped = (uint32_t)read.reading + faults->shaft_slip;
    const uint32_t high = slipped | faults->shaft_high;
    const uint32_t low = high & ~(uint32_t)faults->shaft_low;

    return (hal_shaft_t){
        .reading = read_channel(&faults->shaft, (uint16_t)(low ^ faults->shaft_flip)),
        .index = (uint16_t)(read.index + faults->shaft_slip),
        .indexed = read.indexed && !faults->shaft.forced,
        .age_q8 = read.age_q8,
    };
}

hal_shaft_t hal_shaft(hal_t *hal)
{
    hal_shaft_t shaft = {0};

    if ((hal->plant != NULL) && (hal->plant->shaft.cfg.kind != PLANT_SHAFT_NONE)) {
        shaft = read_plant(hal);
        hal->seen_shaft = shaft;
    } else if (hal->inputs != NULL) {
        shaft = hal->inputs->shaft;
        hal->inputs->shaft.indexed = false;
    } else {
        /* no sensor */
    }
    return shaft;
}

static void drive_plant(hal_t *hal, const drive_out_t *out)
{
    const bool late = hal->faults.late;
    const uint32_t rest = hal->plant->inverter.timer_counts / 2U;
    uint32_t compare[PLANT_LEGS];

    for (uint32_t leg = 0U; leg < PLANT_LEGS; leg++) {
        const uint32_t demand = late ? rest : out->compare.phase[leg];

        compare[leg] = read_channel(&hal->faults.duty[leg], (uint16_t)demand);
    }
    plant_write_compare(hal->plant, compare);
    plant_set_gates(hal->plant, out->gate_enable && !hal->faults.broken);
}

void hal_apply(hal_t *hal, const drive_out_t *out)
{
    hal->late = hal->faults.late;
    hal->late_ticks += hal->late ? 1U : 0U;
    if (hal->plant != NULL) {
        drive_plant(hal, out);
    }
}

void hal_open_gates(hal_t *hal)
{
    if (hal->plant != NULL) {
        plant_set_gates(hal->plant, false);
    }
}

uint32_t hal_ticks(const hal_t *hal)
{
    return hal->ticks;
}
