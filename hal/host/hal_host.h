/* SPDX-License-Identifier: MIT */
/*
 * The binding of hal.h to the simulated hardware: the plant simulates the timer, the converters and
 * the gates.
 *
 * Time stands still between two calls of hal_host_step(), so the control interrupt of tick k sees
 * the plant exactly at t_k, however long it takes. The plant keeps the preload registers: compare
 * values act from t_k+1; opening and enabling the gates act at once.
 *
 * Faults between the plant and the control interrupt are set in hal_t.faults, before the tick that
 * is to see them; a field stays in force until it is changed.
 *
 * A serial line, the flash of the store and inputs exist when they are attached to hal_t. Line and
 * inputs work in hal_host_step().
 */
#ifndef HAL_HOST_H
#define HAL_HOST_H

#include "hal.h"
#include "hal_host_flash.h"
#include "hal_host_inputs.h"
#include "hal_host_line.h"
#include "plant.h"

#include <stdbool.h>
#include <stdint.h>

/* A channel whose count can be replaced: if `forced` is true, `count` replaces the true one. */
typedef struct {
    bool forced;
    uint16_t count;
} hal_host_channel_t;

typedef struct {
    hal_host_channel_t ia;
    hal_host_channel_t ib;
    hal_host_channel_t bus;
    hal_host_channel_t temperature;
    hal_host_channel_t angle;
    hal_host_channel_t
        duty[PLANT_LEGS];     /* compare values of the legs in place of the demanded ones */
    uint16_t angle_offset;    /* added to the sensor's angle, 2^16 to a turn of the shaft */
    hal_host_channel_t shaft; /* reading of the sensor of the shaft */
    uint16_t shaft_high;      /* wires of it that are high, as bits of the reading */
    uint16_t shaft_low;       /* likewise low */
    uint16_t shaft_flip;      /* bits that are flipped */
    uint16_t shaft_slip;      /* counts that an encoder has gained */
    bool broken;              /* the power stage opens the gates by itself and reports a break */
    /*
     * ticks end too late: equal duties of 1/2 (no voltage) act in place of the demand, and the next
     * frame has DRIVE_FLAG_LATE
     */
    bool late;
} hal_host_faults_t;

struct hal {
    plant_t *plant; /* NULL: hal_host_feed() gives the frames */
    drive_in_t fed;
    hal_host_faults_t faults; /* all 0: none */
    bool late;                /* the last tick ended too late */
    uint32_t late_ticks;
    uint16_t seen_ia; /* counts that the last hal_sample() gave */
    uint16_t seen_ib;
    uint16_t seen_ic;
    hal_shaft_t seen_shaft;    /* what the last hal_shaft() gave */
    hal_host_line_t *line;     /* NULL: none */
    hal_host_flash_t *flash;   /* NULL: no store */
    hal_host_inputs_t *inputs; /* NULL: no inputs, and no sensor that hal_shaft() reads */
    uint32_t ticks;            /* PWM periods since hal_host_init() */
    uint32_t kept[HAL_KEPT_WORDS];
    hal_reset_t reset; /* what hal_reset() says */
};

/*
 * Bind to a plant that plant_init() has accepted and that outlives the binding, or to none (NULL).
 * Line, store and inputs are not attached.
 */
void hal_host_init(hal_t *hal, plant_t *plant);

/* Without a plant: sets the frame that the next hal_sample() gives. */
void hal_host_feed(hal_t *hal, const drive_in_t *in);

/* Let one PWM period pass. Call after each control_isr(), never from within. */
void hal_host_step(hal_t *hal);

#endif
