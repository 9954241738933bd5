/* SPDX-License-Identifier: MIT */
/*
 * What unicorn calls so often that it has to be in C: before each block of instructions the time of
 * the emulated core (core.py), some hundred times in a control tick; at each access to a register,
 * as many see again what the one before them saw; and before a decision of the board's code which
 * way it goes (decisions.py).
 */
#include <stdbool.h>
#include <stdint.h>

typedef struct {
    int64_t now;     /* in cycles of 170 MHz */
    int64_t limit;   /* the core stops before the first block at or behind it */
    int64_t cycle;   /* of the core, in such cycles */
    int64_t stopped; /* whether it has */
    uint64_t flash;  /* its first address */
    void (*stop)(void *core);
    uint16_t (*cost_of)(uint64_t address, uint32_t size);
    uint16_t *cost; /* of each half-word: cycles of the block that begins there; 0: not known yet */
    uint64_t halfwords; /* of the flash */
    int64_t access;     /* cycles of an access to a register */
    uint64_t held;      /* the register that shows the same again, see core_clock_read; 0: none */
    uint64_t value;     /* what it shows */
    int64_t until;      /* and before which time */
    uint64_t (*read)(uint64_t address, uint32_t size);
    void (*write)(uint64_t address, uint32_t size, uint64_t value);
} core_clock_t;

typedef struct {
    core_clock_t *clock;
    uint64_t address;
} core_page_t;

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
uint64_t core_clock_read(void *core, uint64_t offset, uint32_t size, void *context);
void core_clock_write(void *core, uint64_t offset, uint32_t size, uint64_t value, void *context);

void core_clock_block(void *core, uint64_t address, uint32_t size, void *context)
{
    core_clock_t *const clock = context;
    uint16_t *const cost = &clock->cost[((address - clock->flash) / 2U) % clock->halfwords];

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

/* A register is held until its time, until something is due, or until another access comes. */
uint64_t core_clock_read(void *core, uint64_t offset, uint32_t size, void *context)
{
    const core_page_t *const page = context;
    core_clock_t *const clock = page->clock;
    const uint64_t address = page->address + offset;
    const int64_t seen_at = clock->now + clock->access;
    const bool nothing_is_due = (seen_at < clock->limit) && (seen_at < clock->until);

    (void)core;
    if ((address == clock->held) && (size == sizeof(uint32_t)) && nothing_is_due) {
        clock->now = seen_at;
        return clock->value;
    }
    clock->held = 0U;
    return clock->read(address, size);
}

void core_clock_write(void *core, uint64_t offset, uint32_t size, uint64_t value, void *context)
{
    const core_page_t *const page = context;

    (void)core;
    page->clock->held = 0U;
    page->clock->write(page->address + offset, size, value);
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
