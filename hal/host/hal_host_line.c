/* SPDX-License-Identifier: MIT */
#include "hal_host_line.h"

#define BYTE_BITS (10U)
#define PS_PER_S (1000000000000U)

void hal_host_line_init(hal_host_line_t *line, uint32_t baud, uint64_t tick_ps)
{
    *line = (hal_host_line_t){.byte_ps = (BYTE_BITS * PS_PER_S) / baud, .tick_ps = tick_ps};
}

/* The queues on the PC's side and on the board's side are rings of `size` bytes. */
static bool put(uint8_t *bytes, uint32_t size, uint32_t first, uint32_t *count, uint8_t byte)
{
    const bool room = *count < size;

    if (room) {
        bytes[(first + *count) % size] = byte;
        (*count)++;
    }
    return room;
}

static bool take(const uint8_t *bytes, uint32_t size, uint32_t *first, uint32_t *count,
                 uint8_t *byte)
{
    const bool there = *count > 0U;

    if (there) {
        *byte = bytes[*first];
        *first = (*first + 1U) % size;
        (*count)--;
    }
    return there;
}

bool hal_host_line_write(hal_host_line_t *line, uint8_t byte)
{
    hal_host_bytes_t *const to = &line->from_pc;

    return put(to->bytes, HAL_HOST_LINE_ROOM, to->first, &to->count, byte);
}

bool hal_host_line_read(hal_host_line_t *line, uint8_t *byte)
{
    hal_host_bytes_t *const from = &line->to_pc;

    return take(from->bytes, HAL_HOST_LINE_ROOM, &from->first, &from->count, byte);
}

bool hal_host_line_receive(hal_host_line_t *line, uint8_t *byte)
{
    hal_host_fifo_t *const from = &line->received;

    return take(from->bytes, HAL_HOST_LINE_FIFO, &from->first, &from->count, byte);
}

bool hal_host_line_send(hal_host_line_t *line, uint8_t byte)
{
    hal_host_fifo_t *const to = &line->sending;

    return put(to->bytes, HAL_HOST_LINE_FIFO, to->first, &to->count, byte);
}

/*
 * Returns how many of the waiting bytes have passed in the time *had_ps, and takes their time off
 * it. When all of them have passed, the rest of the time is lost: later bytes start at 0.
 */
static uint32_t passed(uint64_t *had_ps, uint64_t byte_ps, uint32_t waiting)
{
    const uint64_t most = *had_ps / byte_ps;
    const uint32_t bytes = (most < waiting) ? (uint32_t)most : waiting;

    *had_ps = (bytes < waiting) ? (*had_ps - (bytes * byte_ps)) : 0U;
    return bytes;
}

static void carry_to_board(hal_host_line_t *line)
{
    hal_host_bytes_t *const from = &line->from_pc;
    hal_host_fifo_t *const to = &line->received;
    uint8_t byte = 0U;

    line->in_ps += line->tick_ps;
    for (uint32_t left = passed(&line->in_ps, line->byte_ps, from->count); left > 0U; left--) {
        (void)take(from->bytes, HAL_HOST_LINE_ROOM, &from->first, &from->count, &byte);
        line->lost += put(to->bytes, HAL_HOST_LINE_FIFO, to->first, &to->count, byte) ? 0U : 1U;
    }
}

static void carry_to_pc(hal_host_line_t *line)
{
    hal_host_fifo_t *const from = &line->sending;
    hal_host_bytes_t *const to = &line->to_pc;
    uint8_t byte = 0U;

    line->out_ps += line->tick_ps;
    for (uint32_t left = passed(&line->out_ps, line->byte_ps, from->count); left > 0U; left--) {
        (void)take(from->bytes, HAL_HOST_LINE_FIFO, &from->first, &from->count, &byte);
        line->lost += put(to->bytes, HAL_HOST_LINE_ROOM, to->first, &to->count, byte) ? 0U : 1U;
    }
}

void hal_host_line_step(hal_host_line_t *line)
{
    carry_to_board(line);
    carry_to_pc(line);
}
