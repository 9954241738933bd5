/* SPDX-License-Identifier: MIT */
/*
 * Guard of the configuration: the CRC by its definition, every flipped bit found, in bounded time.
 */
#include "config_guard.h"
#include "example_cfg.h"
#include "testing.h"

#include <stddef.h>
#include <string.h>

static drive_cfg_t cfg;
static config_guard_t guard;
static fault_t fault;

void setUp(void)
{
    cfg = example_drive_cfg();
    config_guard_reset(&guard);
    fault = (fault_t){.id = FAULT_NONE};
}

/* Bit by bit, as the standard says. */
static uint32_t crc_by_definition(const uint8_t *bytes, size_t count)
{
    uint32_t crc = 0xFFFFFFFFU;

    for (size_t k = 0U; k < count; k++) {
        crc ^= bytes[k];
        for (int32_t bit = 0; bit < 8; bit++) {
            crc = (crc >> 1U) ^ (((crc & 1U) != 0U) ? 0xEDB88320U : 0U);
        }
    }
    return ~crc;
}

TEST(test_the_definition_gives_the_standards_check_value)
{
    static const uint8_t digits[] = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};

    TEST_ASSERT_EQUAL_HEX32(0xCBF43926U, crc_by_definition(digits, sizeof digits));
}

TEST(test_crc_covers_all_fields_but_itself)
{
    uint8_t bytes[sizeof cfg];

    memcpy(bytes, &cfg, sizeof cfg);
    TEST_ASSERT_EQUAL_size_t(sizeof cfg - sizeof cfg.crc, offsetof(drive_cfg_t, crc));
    TEST_ASSERT_EQUAL_HEX32(crc_by_definition(bytes, offsetof(drive_cfg_t, crc)),
                            config_guard_crc(&cfg));
}

TEST(test_an_unchanged_configuration_is_never_a_fault)
{
    for (uint32_t k = 0U; k < (5U * CONFIG_GUARD_STEPS); k++) {
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, config_guard_step(&guard, &cfg, &fault));
    }
}

/* Steps until the fault, from a state in the middle of a round. */
static uint32_t steps_to_fault(void)
{
    const uint32_t bound = 2U * (uint32_t)CONFIG_GUARD_STEPS;

    for (uint32_t k = 1U; k <= bound; k++) {
        if (config_guard_step(&guard, &cfg, &fault) != FAULT_NONE) {
            return k;
        }
    }
    TEST_FAIL_MESSAGE("a changed configuration was not found within two rounds");
    return 0U;
}

TEST(test_every_flipped_bit_is_found_within_two_rounds)
{
    for (size_t bit = 0U; bit < (8U * sizeof cfg); bit++) {
        uint8_t bytes[sizeof cfg];

        setUp();
        for (size_t k = 0U; k < (CONFIG_GUARD_STEPS / 2U); k++) {
            (void)config_guard_step(&guard, &cfg, &fault);
        }
        memcpy(bytes, &cfg, sizeof cfg);
        bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        memcpy(&cfg, bytes, sizeof cfg);
        (void)steps_to_fault();
        TEST_ASSERT_EQUAL_INT(FAULT_CONFIGURATION, fault.id);
        TEST_ASSERT_EQUAL_HEX32(cfg.crc, (uint32_t)fault.limit);
        TEST_ASSERT_EQUAL_HEX32(config_guard_crc(&cfg), (uint32_t)fault.value);
    }
}

TEST(test_a_place_beyond_the_configuration_is_found_and_the_round_begins_again)
{
    guard.at = CONFIG_GUARD_STEPS * 4U;
    TEST_ASSERT_EQUAL_INT(FAULT_MEMORY, config_guard_step(&guard, &cfg, &fault));
    TEST_ASSERT_EQUAL_INT(FAULT_MEMORY, fault.id);
    TEST_ASSERT_EQUAL_INT32(CONFIG_GUARD_STEPS * 4U, fault.value);
    for (uint32_t k = 0U; k < (2U * CONFIG_GUARD_STEPS); k++) {
        TEST_ASSERT_EQUAL_INT(FAULT_NONE, config_guard_step(&guard, &cfg, &fault));
    }
}

/* Two flips of the highest bit in words two apart cancel in both of Fletcher's sums of 32 bits. */
TEST(test_two_flipped_highest_bits_are_found)
{
    cfg.observer.decay ^= INT32_MIN;
    cfg.observer.volt_gain ^= INT32_MIN;
    (void)steps_to_fault();
    TEST_ASSERT_EQUAL_INT(FAULT_CONFIGURATION, fault.id);
}
