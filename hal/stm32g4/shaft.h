/* SPDX-License-Identifier: MIT */
/*
 * The sensor of the shaft: Hall sensors, an incremental encoder or an absolute one. RM0440 29.4.20
 * (encoder mode), 39.5 (SPI).
 *
 * Hall sensors are three pins. If they are channels 1 to 3 of timer 3 or 4, each of their edges
 * sets the counter of that timer to 0, so it tells the time since the last edge. The edges of an
 * incremental encoder are counted by timer 3 or 4, which also captures its count at the index. The
 * filter of their inputs takes what is shorter than 94 ns away.
 *
 * An absolute encoder of the AS5047's kind samples its angle when its chip select rises, and sends
 * it in the next frame. The select rises when a tick begins, and falls when the last frame is read.
 * The next frame is started when the tick ends. So the frame that a tick reads has the angle at the
 * beginning of the tick before. AS5047D, timing of the SPI: the select has to be high for 350 ns,
 * and low for 350 ns before the clock starts. After a late tick a frame may still be under way when
 * the next one begins. Then the select stays low, and this tick starts no frame.
 */
#ifndef SHAFT_H
#define SHAFT_H

#include "board.h"
#include "hal.h"
#include "hal_config.h"
#include "reg.h"
#include "stm32g4.h"

#include <stdint.h>

/*
 * Reads the angle, with an even parity. Of an absolute encoder whose frame was not received, it is
 * what hal_shaft() returns, too: an angle with the error flag set.
 */
#define SHAFT_ONES (0xFFFFU)

/*
 * Starts timer or SPI. An absolute encoder is asked for its first angle. Call once, after
 * pins_init().
 */
void shaft_init(void);

/* As hal_shaft(). */
hal_shaft_t shaft_read(void);

/* Lets an absolute encoder sample, if no frame is under way. Context: control interrupt, first. */
static inline void shaft_sample(void)
{
    if ((BOARD.shaft == BOARD_SHAFT_ABSOLUTE) && !reg_any(HAL_SPI + SPI_SR, SPI_SR_BSY)) {
        reg_write(HAL_SPI_CS_PORT + GPIO_BSRR, 1UL << HAL_SPI_CS_BIT);
    }
}

/*
 * Starts the frame of an absolute encoder, if shaft_read() has selected it in this tick. Context:
 * control interrupt, last.
 */
void shaft_start(void);

#endif
