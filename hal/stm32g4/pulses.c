/* SPDX-License-Identifier: MIT */
#include "pulses.h"

#include "board.h"
#include "hal_config.h"
#include "reg.h"
#include "settings.h"
#include "stm32g4.h"

_Static_assert(((PULSES_PRESCALER + 1U) * HAL_PULSE_HZ) == BOARD_CLOCK_HZ,
               "timer 2 counts in 1/HAL_PULSE_HZ");

#define HALF_OF_TIME (0x80000000U)

typedef struct {
    const volatile uint32_t *slots;
    uint32_t left; /* address of the register with the transfers to the end of the ring */
    uint32_t at;   /* slot of the next edge */
    uint32_t last; /* the edge before it, which is in the slot before */
} ring_t;

volatile uint32_t pulses_rises[PULSES_SLOTS];
volatile uint32_t pulses_falls[PULSES_SLOTS];

static ring_t rises = {.slots = pulses_rises, .left = DMA1_CNDTR1};
static ring_t falls = {.slots = pulses_falls, .left = DMA1_CNDTR2};
static uint32_t rise; /* the rising edge that waits for its falling edge */
static bool has_rise;

void pulses_init(void)
{
    reg_write(DMA1_CNDTR1, PULSES_SLOTS);
    reg_write(DMA1_CNDTR2, PULSES_SLOTS);
    settings_write(SETTINGS_PULSES);
    reg_write(TIM2 + TIM_EGR, TIM_EGR_UG); /* the prescaler is loaded */
    reg_write(TIM2 + TIM_CR1, TIM_CR1_CEN);
}

uint32_t pulses_now(void)
{
    return reg_read(TIM2 + TIM_CNT);
}

/* The slot that the DMA fills next. */
static uint32_t end_of(const ring_t *ring)
{
    const uint32_t end = PULSES_SLOTS - reg_read(ring->left);

    return (end < PULSES_SLOTS) ? end : 0U;
}

static uint32_t edge_before(const ring_t *ring, uint32_t slot)
{
    return ring->slots[((slot > 0U) ? slot : PULSES_SLOTS) - 1U];
}

/* Leaves out all edges up to now. */
static void skip_edges(ring_t *ring)
{
    ring->at = end_of(ring);
    ring->last = edge_before(ring, ring->at);
}

/*
 * Takes the next edge of a ring. The slot before it has its old content as long as the DMA has
 * not been all around the ring. So if that slot is looked at last and is as it was, the edge
 * follows the one before without a gap. Otherwise all edges up to now are left out.
 */
static bool take_edge(ring_t *ring, uint32_t *edge)
{
    bool taken = ring->at != end_of(ring);

    if (taken) {
        const uint32_t found = ring->slots[ring->at];

        taken = edge_before(ring, ring->at) == ring->last;
        if (taken) {
            *edge = found;
            ring->last = found;
            ring->at = ((ring->at + 1U) < PULSES_SLOTS) ? (ring->at + 1U) : 0U;
        } else {
            skip_edges(ring);
        }
    }
    return taken;
}

/*
 * Another capture came before the DMA had moved the last one: there is a gap, and an edge of before
 * it may still be moved. So no rising edge of before this instant is paired any more.
 */
static void watch_loss(void)
{
    if (reg_any(TIM2 + TIM_SR, HAL_PULSES_LOST)) {
        reg_write(TIM2 + TIM_SR, ~HAL_PULSES_LOST);
        skip_edges(&rises);
        skip_edges(&falls);
        has_rise = false;
    }
}

/* Whether one time comes after another one. The time wraps. */
static bool is_after(uint32_t time, uint32_t other)
{
    return ((other - time) & HALF_OF_TIME) != 0U;
}

/* The last falling edge; not more than HAL_PULSE_MAX ago, so that the time does not wrap. */
static uint32_t earliest_rise(void)
{
    const uint32_t now = pulses_now();

    return ((now - falls.last) < HAL_PULSE_MAX) ? falls.last : (now - HAL_PULSE_MAX);
}

/* Goes on to the first rising edge after `from`. */
static void follow_rises(uint32_t from)
{
    while (!(has_rise && is_after(rise, from)) && take_edge(&rises, &rise)) {
        has_rise = true;
    }
    has_rise = has_rise && is_after(rise, from);
}

/*
 * Two falling edges that follow each other without a gap have exactly one rising edge between them.
 * So a rising edge after the first and before the second belongs to the second one, whatever else
 * was lost.
 */
bool pulses_take(hal_pulse_t *pulse)
{
    uint32_t from;
    uint32_t end = 0U;
    bool whole;

    watch_loss();
    from = earliest_rise();
    whole = take_edge(&falls, &end);
    follow_rises(from);
    whole = whole && has_rise && is_after(end, rise);
    if (whole) {
        *pulse = (hal_pulse_t){.start = rise, .width = end - rise};
    }
    return whole;
}
