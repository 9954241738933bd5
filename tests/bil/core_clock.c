/*
 * The time of the emulated core, loaded by core.py: unicorn calls this before each block of instructions. In C, as
 * there are some hundred of them in a control tick.
 */
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

void core_clock_block(void *core, uint64_t address, uint32_t size, void *context);

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
