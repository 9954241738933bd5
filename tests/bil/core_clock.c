/* SPDX-License-Identifier: MIT */
/*
 * What unicorn calls so often that it has to be in C: before each block of instructions the time of the emulated core
 * (core.py), some hundred times in a control tick, and before a decision of the board's code which way it goes
 * (decisions.py).
 */
#include <stdbool.h>
#include <stdint.h>

enum {
    HALFWORDS = 0x20000 / 2
}; /* of the flash */

typedef struct {
    int64_t now;     /* in cycles of 170 MHz */
    int64_t limit;   /* the core stops before the first block at or behind it */
    int64_t cycle;   /* of the core, in such cycles */
    int64_t stopped; /* whether it has */
    uint64_t flash;  /* its first address */
    void (*stop)(void *core);
    uint16_t (*cost_of)(uint64_t address, uint32_t size);
    uint16_t *cost; /* of each half-word: cycles of the block that begins there; 0: not known yet */
} core_clock_t;

typedef struct {
    int (*read)(void *core, int id, uint32_t *value);
    int32_t register_;  /* what is looked at: the flags, or the register that is compared with 0 */
    int32_t condition;  /* as an instruction encodes it; 14: is 0; 15: is not 0 */
    uint64_t counts[2]; /* how often it did not hold, and did */
} core_decision_t;

enum {
    IS_ZERO = 14,
    IS_NOT_ZERO = 15
};

void core_clock_block(void *core, uint64_t address, uint32_t size, void *context);
void core_clock_decision(void *core, uint64_t address, uint32_t size, void *context);

void core_clock_block(void *core, uint64_t address, uint32_t size, void *context)
{
    core_clock_t *const clock = context;
    uint16_t *const cost = &clock->cost[((address - clock->flash) / 2U) % HALFWORDS];

    if (clock->now >= clock->limit) {
        clock->stopped = 1;
        clock->stop(core);
        return;
    }
    if (*cost == 0U) {
        *cost = clock->cost_of(address, size);
    }
    clock->now += *cost * clock->cycle;
}

/* Armv7-M ARM, A7.3.1: of each pair of conditions the second is the opposite of the first. */
static bool holds(int32_t condition, uint32_t flags)
{
    const bool negative = ((flags >> 31) & 1U) != 0U;
    const bool zero = ((flags >> 30) & 1U) != 0U;
    const bool carry = ((flags >> 29) & 1U) != 0U;
    const bool overflow = ((flags >> 28) & 1U) != 0U;
    const bool first[] = {zero,
                          carry,
                          negative,
                          overflow,
                          carry && !zero,
                          negative == overflow,
                          !zero && (negative == overflow)};

    return first[condition / 2] != ((condition % 2) != 0);
}

void core_clock_decision(void *core, uint64_t address, uint32_t size, void *context)
{
    core_decision_t *const decision = context;
    uint32_t value = 0U;
    bool is_so = false;

    (void)address;
    (void)size;
    (void)decision->read(core, decision->register_, &value);
    if (decision->condition >= IS_ZERO) {
        is_so = (value == 0U) == (decision->condition == IS_ZERO);
    } else {
        is_so = holds(decision->condition, value);
    }
    decision->counts[is_so ? 1 : 0]++;
}
