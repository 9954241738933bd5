/* SPDX-License-Identifier: MIT */
/* The serial line of the simulated hardware: its rate, its FIFOs, and what is not attached. */
#include "hal_host.h"
#include "testing.h"

#include <string.h>

#define TICKS_PER_S (10000U)
#define TICK_PS (100000000U)
#define BAUD (115200U)
#define FAST_BAUD (921600U) /* 9.2 bytes a tick: more than a FIFO holds */
#define BYTES_PER_S (BAUD / 10U)
/* bytes that leave in the last tick, which nobody fills up: 1.15, rounded up */
#define LAST_ROOM (2U)

static hal_host_line_t line;
static hal_t hardware;

void setUp(void)
{
    hal_host_init(&hardware, NULL);
    hal_host_line_init(&line, BAUD, TICK_PS);
    hardware.line = &line;
}

/*
 * Bytes that the board can send in a second, offered as a background does: once a tick, until there
 * is no room.
 */
static uint32_t sent_in_a_second(void)
{
    uint32_t bytes = 0U;

    for (uint32_t k = 0U; k < TICKS_PER_S; k++) {
        while (hal_send(&hardware, (uint8_t)bytes)) {
            bytes++;
        }
        hal_host_step(&hardware);
    }
    return bytes;
}

/* Written by the PC at once, and taken by the board once a tick, up to `most` of them a tick. */
static uint32_t received_of(uint32_t bytes, uint32_t most)
{
    uint32_t taken = 0U;
    uint8_t byte = 0U;

    for (uint32_t k = 0U; k < bytes; k++) {
        TEST_ASSERT_TRUE(hal_host_line_write(&line, (uint8_t)k));
    }
    for (uint32_t k = 0U; k < TICKS_PER_S; k++) {
        hal_host_step(&hardware);
        for (uint32_t left = most; (left > 0U) && hal_receive(&hardware, &byte); left--) {
            taken++;
        }
    }
    return taken;
}

TEST(test_it_sends_as_many_bytes_as_its_rate_allows_and_a_fifo_more)
{
    TEST_ASSERT_UINT32_WITHIN(LAST_ROOM, BYTES_PER_S + HAL_HOST_LINE_FIFO, sent_in_a_second());
}

TEST(test_above_a_fifo_a_tick_it_sends_a_fifo_a_tick)
{
    hal_host_line_init(&line, FAST_BAUD, TICK_PS);
    TEST_ASSERT_EQUAL_UINT32(HAL_HOST_LINE_FIFO * TICKS_PER_S, sent_in_a_second());
}

TEST(test_bytes_arrive_in_order_and_not_before_their_time)
{
    uint8_t byte = 0U;

    TEST_ASSERT_TRUE(hal_host_line_write(&line, 7U));
    TEST_ASSERT_TRUE(hal_host_line_write(&line, 9U));
    TEST_ASSERT_FALSE(hal_receive(&hardware, &byte));
    hal_host_step(&hardware); /* 1.15 bytes a tick */
    TEST_ASSERT_TRUE(hal_receive(&hardware, &byte));
    TEST_ASSERT_EQUAL_UINT8(7U, byte);
    TEST_ASSERT_FALSE(hal_receive(&hardware, &byte));
    TEST_ASSERT_EQUAL_UINT8(7U, byte);
    hal_host_step(&hardware);
    TEST_ASSERT_TRUE(hal_receive(&hardware, &byte));
    TEST_ASSERT_EQUAL_UINT8(9U, byte);
}

TEST(test_what_the_board_sends_is_what_the_pc_reads)
{
    uint8_t byte = 0U;

    TEST_ASSERT_TRUE(hal_send(&hardware, 5U));
    TEST_ASSERT_FALSE(hal_host_line_read(&line, &byte));
    hal_host_step(&hardware);
    TEST_ASSERT_TRUE(hal_host_line_read(&line, &byte));
    TEST_ASSERT_EQUAL_UINT8(5U, byte);
    TEST_ASSERT_FALSE(hal_host_line_read(&line, &byte));
}

TEST(test_nothing_is_lost_while_the_board_takes_what_comes)
{
    TEST_ASSERT_EQUAL_UINT32(BYTES_PER_S / 2U, received_of(BYTES_PER_S / 2U, HAL_HOST_LINE_FIFO));
    TEST_ASSERT_EQUAL_UINT32(0U, line.lost);
}

TEST(test_bytes_that_find_the_receiver_full_are_lost_and_counted)
{
    const uint32_t taken = received_of(100U, 0U);

    TEST_ASSERT_EQUAL_UINT32(0U, taken);
    TEST_ASSERT_EQUAL_UINT32(100U - HAL_HOST_LINE_FIFO, line.lost);
}

TEST(test_bytes_that_nobody_reads_are_lost_once_the_side_of_the_pc_is_full)
{
    uint32_t sent = 0U;

    while (sent < (HAL_HOST_LINE_ROOM + HAL_HOST_LINE_FIFO + BYTES_PER_S)) {
        sent += sent_in_a_second();
    }
    TEST_ASSERT_EQUAL_UINT32(HAL_HOST_LINE_ROOM, line.to_pc.count);
    TEST_ASSERT_EQUAL_UINT32(sent - HAL_HOST_LINE_ROOM - line.sending.count, line.lost);
}

TEST(test_the_pc_is_told_when_its_side_is_full)
{
    for (uint32_t k = 0U; k < HAL_HOST_LINE_ROOM; k++) {
        TEST_ASSERT_TRUE(hal_host_line_write(&line, 1U));
    }
    TEST_ASSERT_FALSE(hal_host_line_write(&line, 1U));
}

TEST(test_without_line_and_flash_nothing_is_sent_received_or_stored)
{
    uint8_t bytes[HAL_STORE_UNIT_BYTES] = {1U};

    hardware.line = NULL;
    TEST_ASSERT_FALSE(hal_send(&hardware, 1U));
    TEST_ASSERT_FALSE(hal_receive(&hardware, bytes));
    TEST_ASSERT_FALSE(hal_store_read(&hardware, 0U, 0U, bytes));
    TEST_ASSERT_FALSE(hal_store_erase(&hardware, 0U));
    TEST_ASSERT_FALSE(hal_store_program(&hardware, 0U, 0U, bytes));
    hal_host_step(&hardware);
    TEST_ASSERT_EQUAL_UINT32(1U, hal_ticks(&hardware));
}

TEST(test_an_attached_flash_keeps_what_is_programmed_until_it_is_erased)
{
    static hal_host_flash_t flash;
    const uint8_t written[HAL_STORE_UNIT_BYTES] = {1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U};
    uint8_t read[HAL_STORE_UNIT_BYTES] = {0U};

    hal_host_flash_init(&flash, 1U);
    hardware.flash = &flash;
    TEST_ASSERT_TRUE(hal_store_program(&hardware, 1U, 3U, written));
    TEST_ASSERT_TRUE(hal_store_read(&hardware, 1U, 3U, read));
    TEST_ASSERT_EQUAL_MEMORY(written, read, sizeof read);
    TEST_ASSERT_FALSE(hal_store_program(&hardware, 1U, 3U, written));
    TEST_ASSERT_TRUE(hal_store_erase(&hardware, 1U));
    TEST_ASSERT_TRUE(hal_store_read(&hardware, 1U, 3U, read));
    TEST_ASSERT_EACH_EQUAL_UINT8(0xFFU, read, sizeof read);
}
