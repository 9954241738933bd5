/* SPDX-License-Identifier: MIT */
/*
 * The whole contract between the application and the hardware: four functions for the control
 * interrupt and a fifth for a sensor of the shaft, three for the console and the link of
 * firmware/app, three for its inputs, three for its store and its black box, two for words that
 * survive a reset, and one for the reason of the reset.
 *
 * The build links exactly one binding. A binding owns the PWM timer, the converters, the gate
 * drivers and the serial line; no code above it uses a register. docs/porting.md says how to write
 * one.
 *
 * Timing. The PWM is centre aligned. The control interrupt runs once per PWM period, started by the
 * conversion in the middle of the low-side on-time (t_k). hal_apply() preloads the compare values
 * in that interrupt. They act for one period from t_k+1, the next such instant.
 */
#ifndef HAL_H
#define HAL_H

#include "io.h"

#include <stdbool.h>
#include <stdint.h>

/* Opaque: the data of the binding. A target may have exactly one. */
typedef struct hal hal_t;

/*
 * Fill the measured part of the frame (adc_ia, adc_ib, adc_bus, adc_temperature, angle, flags) with
 * the conversions of t_k. Leave its command as it is, because it stays in force from tick to tick.
 * The temperature may be older than t_k. The angle is 0 without a sensor. Context: control
 * interrupt, first. Does not wait: the conversions are complete when it is called.
 */
void hal_sample(hal_t *hal, drive_in_t *in);

/*
 * Preload the three compare values, and open or enable the gates. Opening acts at once, by hardware
 * where there is a main output enable. Enabling acts at t_k+1 at the latest.
 * Context: control interrupt, last. Must finish before t_k+1. If it does not, the binding applies
 * equal duty to all phases from t_k+1 to t_k+2, thus no voltage, and sets DRIVE_FLAG_LATE in the
 * next frame.
 */
void hal_apply(hal_t *hal, const drive_out_t *out);

/* What the sensor of the shaft tells, as it is; firmware/ makes an angle of it. */
typedef struct {
    /*
     * Hall sensors: their levels, bit 0 is sensor 1, bits 3 to 15 are 0. Incremental encoder: its
     * counter, 4 counts to a line, wrapping at 16 bits; it counts up when A leads B. Absolute
     * encoder: the frame of 16 bits that was received last, as it came over the wires.
     */
    uint16_t reading;
    uint16_t index; /* incremental encoder: the counter at the last index pulse */
    bool indexed;   /* incremental encoder: an index pulse has come since the last call */
    /*
     * Hall sensors: time since the last edge, Q8 of a control tick, at least 1; 0: the binding
     * cannot tell. Only the age of an edge of the last tick is used.
     */
    uint16_t age_q8;
} hal_shaft_t;

/*
 * The sensor's reading at t_k. That of an absolute encoder is one tick old, because its frame is
 * transferred meanwhile: it is the angle at t_k-1, or 0xFFFF if no frame came. A board without a
 * sensor returns zeros. Context: control interrupt, once a tick, after hal_sample(). Does not wait.
 */
hal_shaft_t hal_shaft(hal_t *hal);

/* Open the gates now. Context: any, also before the first tick and from fault handlers. */
void hal_open_gates(hal_t *hal);

/*
 * Free-running time in control ticks since the start, wrapping. Context: any. For time stamps in
 * the background; the control step itself has no clock.
 */
uint32_t hal_ticks(const hal_t *hal);

/*
 * The serial line. Context: background only, never the control interrupt. Neither function waits.
 *
 * hal_receive() gives the next received byte. When there is none, it returns false and leaves
 * `byte` as it is. The link (link.h) takes the received bytes once per pass of the background, so
 * the FIFO or buffer of the hardware has to hold the bytes of one pass. A byte that is lost or
 * received with an error is left out.
 *
 * hal_send() takes a byte for sending. While there is no room, it returns false and does nothing;
 * the caller offers the byte again in the next pass. Room for a single byte is enough.
 *
 * A board without a serial line returns false from both.
 */
bool hal_receive(hal_t *hal, uint8_t *byte);
bool hal_send(hal_t *hal, uint8_t byte);

/*
 * The inputs through which a board is commanded without a serial line. Context: background only.
 * None of the three functions waits.
 *
 * Times of pulses are in 1/HAL_PULSE_HZ, 0.1 µs, from any instant on, and wrap at 32 bits, after
 * some 429 s.
 */
#define HAL_PULSE_HZ (10000000U)

/* A high time of the command pin. */
typedef struct {
    uint32_t start; /* its rising edge, in 1/HAL_PULSE_HZ */
    uint32_t width; /* from the rising to the falling edge, in 1/HAL_PULSE_HZ */
} hal_pulse_t;

/*
 * Gives the next pulse that has ended, oldest first. When there is none, it returns false and
 * leaves `pulse` as it is. The binding holds at least the pulses of two DShot600 frames, 32. When
 * more come before they are fetched, some are lost, but those that are given are pulses of the pin:
 * a rising edge is never paired with the falling edge of another pulse. A pulse of more than
 * HAL_PULSE_MAX is no pulse, but a level: it may be left out. On a noisy line pulses may come as
 * fast as they are fetched, so a caller fetches a limited number in a pass.
 */
#define HAL_PULSE_MAX (10000000U)
bool hal_pulse(hal_t *hal, hal_pulse_t *pulse);

/* The present time, on the scale of hal_pulse_t.start. */
uint32_t hal_pulse_now(const hal_t *hal);

/* The throttle of a board that has none. */
#define HAL_NO_THROTTLE (0xFFFFU)

typedef struct {
    /*
     * count of the throttle's voltage, 0 to full scale of the converter as adc_bus, 4095 with 12
     * bits; at most some 60 ms old. HAL_NO_THROTTLE: the board has none
     */
    uint16_t throttle;
    /*
     * conversions of the throttle that have ended, wrapping; goes up by 1 for each, some 60 ms
     * apart at most, and only when one has ended: a count that stands still is a converter that
     * does
     */
    uint8_t conversions;
    bool button; /* the button is pressed at this moment, not debounced; false: there is none */
} hal_inputs_t;

hal_inputs_t hal_inputs(const hal_t *hal);

/*
 * Values that only the binding knows. The control interrupt does not use them. The background shows
 * them to the user; it also checks adc_ic against the other two currents, and answers a request
 * that needs the tick with a refusal when tick_lost is set.
 */
typedef struct {
    /*
     * current of the third phase, as adc_ia; on a board that does not measure it, 3 · half scale −
     * adc_ia − adc_ib
     */
    uint16_t adc_ic;
    uint32_t late_ticks; /* ticks that ended too late, since the start */
    uint32_t load_pct;   /* longest tick that was not late, % of a PWM period; 0: not measured */
    bool tick_lost;      /* the control interrupt has stayed away, and will not come again */
    /*
     * the fault of the chip for which the binding keeps the gates open until a reset; NULL: none
     */
    const char *why_barred;
} hal_health_t;

/* Context: background; the tick may come in between. Does not wait. */
hal_health_t hal_health(const hal_t *hal);

/*
 * Slots of flash that keep their bytes without power: the first two belong to the store (store.h),
 * the HAL_BOX_SLOTS after them to the black box (box.h). A slot is one or more pages that contain
 * nothing else. It is erased as a whole and then programmed in units, each once; erased bytes are
 * 0xFF.
 *
 * Context: background, before the control interrupt is enabled, or while the drive rests with open
 * gates: an erase may stop the whole chip for tens of milliseconds. The binding makes sure that its
 * guards do not take this for a fault. `slot` is below HAL_FLASH_SLOTS, `unit` below
 * HAL_STORE_UNITS. A board without a store returns false from all three, and a board without a
 * black box from all three for its slots.
 */
#define HAL_STORE_SLOTS (2U)
#define HAL_BOX_SLOTS (6U)
#define HAL_FLASH_SLOTS (HAL_STORE_SLOTS + HAL_BOX_SLOTS)
#define HAL_STORE_UNITS (256U) /* units in a slot */
#define HAL_STORE_UNIT_BYTES (8U)

/*
 * Copies a unit to `bytes`. False when the flash cannot read the unit, for example because a loss
 * of power has interrupted its programming; then `bytes` may be anything.
 */
bool hal_store_read(hal_t *hal, uint32_t slot, uint32_t unit, uint8_t bytes[HAL_STORE_UNIT_BYTES]);

/* Erases a slot. False when the flash reports a failure. */
bool hal_store_erase(hal_t *hal, uint32_t slot);

/*
 * Programs an erased unit. False when the flash reports a failure. Returns after the unit has been
 * programmed.
 */
bool hal_store_program(hal_t *hal, uint32_t slot, uint32_t unit,
                       const uint8_t bytes[HAL_STORE_UNIT_BYTES]);

/*
 * Words that survive a reset as long as the supply stays, for example backup registers or a RAM
 * that the start-up does not clear. After a loss of the supply, and on a board without such words,
 * they may be anything, so the caller has to keep a check word with them. `index` is below
 * HAL_KEPT_WORDS. Context: background, and before the control interrupt is enabled. Neither
 * function waits.
 */
#define HAL_KEPT_WORDS (6U)

void hal_keep(hal_t *hal, uint32_t index, uint32_t word);
uint32_t hal_kept(const hal_t *hal, uint32_t index);

/* Why the chip has started. The numbers are part of recordings, so new ones go to the end. */
typedef enum {
    HAL_RESET_UNKNOWN = 0,
    HAL_RESET_SUPPLY, /* the supply was switched on, or was too low */
    HAL_RESET_PIN,
    HAL_RESET_SOFTWARE, /* a request of the software, or of a debugger */
    HAL_RESET_WATCHDOG,
    HAL_RESET_OTHER, /* one that this image never makes: low power, option bytes */
    HAL_RESETS
} hal_reset_reason_t;

typedef struct {
    hal_reset_reason_t reason;
    /* number of the exception that nobody expected and that stopped the run before; 0: none did */
    uint32_t exception;
} hal_reset_t;

/* The last reset; the same at each call. Context: background, and before the control interrupt. */
hal_reset_t hal_reset(const hal_t *hal);

#endif
