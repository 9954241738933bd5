/* SPDX-License-Identifier: MIT */
/*
 * The emulator's hook for blocks: notes those of one function's calls. Native, as it runs a hundred
 * times a tick.
 */
#include <stdint.h>

#define BLOCKS_MAX (1U << 16)

typedef struct {
    uint32_t address;
    uint32_t size;
} block_t;

/* As in machine.py. */
typedef struct {
    uint32_t entry;
    uint32_t back; /* where the call returns to */
    uint32_t is_open;
    uint32_t count; /* of blocks; those beyond BLOCKS_MAX are counted and not noted */
    void (*begin)(void);
    void (*end)(void);
    block_t blocks[BLOCKS_MAX];
} trail_t;

void note_block(void *core, uint64_t address, uint32_t size, void *data);

void note_block(void *core, uint64_t address, uint32_t size, void *data)
{
    trail_t *const trail = data;

    (void)core;
    if (trail->is_open == 0U) {
        if (address != trail->entry) {
            return;
        }
        trail->is_open = 1U;
        trail->count = 0U;
        trail->begin();
    }
    if (trail->count < BLOCKS_MAX) {
        trail->blocks[trail->count] = (block_t){.address = (uint32_t)address, .size = size};
    }
    trail->count++;
    if (address == trail->back) {
        trail->is_open = 0U;
        trail->end();
    }
}
