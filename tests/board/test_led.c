/* SPDX-License-Identifier: MIT */
/* The status LED, on a page of memory where the chip has the port's registers. */
#include "board.h"
#include "led.h"
#include "stm32g4.h"
#include "testing.h"

#include <string.h>
#include <sys/mman.h>

#define PAGE (4096U)
#define SET_PC6 (1UL << 6)
#define RESET_PC6 (1UL << 22)
#define TICKS_PER_SECOND (10000U) /* 170 MHz over two times 8500 */
#define SLOW_TICKS (TICKS_PER_SECOND / 2U)
#define FAST_TICKS (TICKS_PER_SECOND / 8U)

const board_t BOARD = {
    .timer_counts = 8500U, .led_port = GPIOC, .led_on = SET_PC6, .led_off = RESET_PC6};

static unsigned char *port;

void setUp(void)
{
    void *const page = (void *)(uintptr_t)(GPIOC / PAGE * PAGE);

    if (port == NULL) {
        port = mmap(page, PAGE, PROT_READ | PROT_WRITE,
                    MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED_NOREPLACE, -1, 0);
    }
    TEST_ASSERT_EQUAL_PTR(page, port);
}

static bool is_on(drive_state_t state, uint32_t ticks)
{
    uint32_t written;

    led_show(state, ticks);
    memcpy(&written, &port[(GPIOC % PAGE) + GPIO_BSRR], sizeof written);
    TEST_ASSERT_TRUE((written == SET_PC6) || (written == RESET_PC6));
    return written == SET_PC6;
}

static void assert_blinks(drive_state_t state, uint32_t half)
{
    TEST_ASSERT_FALSE(is_on(state, 0U));
    TEST_ASSERT_FALSE(is_on(state, half - 1U));
    TEST_ASSERT_TRUE(is_on(state, half));
    TEST_ASSERT_TRUE(is_on(state, (2U * half) - 1U));
    TEST_ASSERT_FALSE(is_on(state, 2U * half));
}

TEST(test_it_blinks_once_a_second_when_ready_and_four_times_after_a_fault)
{
    assert_blinks(DRIVE_STATE_READY, SLOW_TICKS);
    assert_blinks(DRIVE_STATE_PROBE, SLOW_TICKS);
    assert_blinks(DRIVE_STATE_ALIGN, SLOW_TICKS);
    assert_blinks(DRIVE_STATE_FAULT, FAST_TICKS);
}

TEST(test_it_is_on_all_the_time_while_the_drive_runs)
{
    for (uint32_t ticks = 0U; ticks < (2U * TICKS_PER_SECOND); ticks += FAST_TICKS) {
        TEST_ASSERT_TRUE(is_on(DRIVE_STATE_RUN, ticks));
    }
}
