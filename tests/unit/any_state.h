/* SPDX-License-Identifier: MIT */
/* A drive in any state within state.def. Each test program has the words once. */
#ifndef ANY_STATE_H
#define ANY_STATE_H

#include "drive.h"
#include "seeded.h"
#include "transitions.h"

#include <stddef.h>
#include <string.h>

#define STATE_WORDS_COUNT (sizeof(STATE_WORDS) / sizeof(STATE_WORDS[0]))

typedef struct {
    const char *name;
    size_t offset;
    size_t size;
    int64_t lo;
    int64_t hi;
} state_word_t;

#define FIELD(path, lo, hi, quantity) \
    {#path, offsetof(drive_t, path), sizeof(((drive_t *)NULL)->path), lo, hi},
#define FREE(path, quantity) \
    {#path, offsetof(drive_t, path), sizeof(((drive_t *)NULL)->path), INT64_MIN, INT64_MAX},
static const state_word_t STATE_WORDS[] = {
#include "state.def"
};
#undef FIELD
#undef FREE

/* An end of the range as often as a quarter of the time. */
static inline int64_t any_within(seeded_t *seed, int64_t lo, int64_t hi)
{
    const uint64_t high = seeded_u32(seed);
    const uint64_t any = (high << 32U) | seeded_u32(seed);
    const uint64_t span = ((uint64_t)hi - (uint64_t)lo) + 1U;
    const int32_t choice = seeded_in(seed, 0, 7);
    const int64_t inside = (int64_t)((uint64_t)lo + ((span == 0U) ? any : (any % span)));

    return (choice == 0) ? lo : ((choice == 1) ? hi : inside);
}

static inline drive_t any_state(seeded_t *seed, const drive_cfg_t *with)
{
    drive_t any;

    memset(&any, 0, sizeof any);
    for (size_t i = 0; i < STATE_WORDS_COUNT; i++) {
        const int64_t value = any_within(seed, STATE_WORDS[i].lo, STATE_WORDS[i].hi);

        memcpy((char *)&any + STATE_WORDS[i].offset, &value,
               STATE_WORDS[i].size); /* the low bytes come first */
    }
    any.cfg = with;
    any.state = transitions_state(seeded_u32(seed) % DRIVE_STATES);
    any.guard.at = 0U;
    return any;
}

#endif
