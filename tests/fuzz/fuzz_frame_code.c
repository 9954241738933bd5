/* SPDX-License-Identifier: MIT */
/*
 * Any bytes as a code of frames; and what was decoded, coded again.
 *
 * The input is the number of entries, then the code.
 */
#include "frame_code.h"
#include "fuzzed.h"

#include <string.h>

#define ROOM (4096U)

/* The words that a code carries; of the outputs there is nothing. */
static void comes_back(const recorder_entry_t *entries, uint32_t count)
{
    recorder_entry_t again[FRAME_CODE_ENTRIES_MAX];
    uint8_t code[ROOM];
    uint32_t length = 0U;

    HOLDS(frame_code_encode(entries, count, code, ROOM, &length) == count,
          "all entries fit into the longest code");
    HOLDS(frame_code_decode(code, length, again, count), "what was encoded is a code");
    HOLDS(memcmp(entries, again, count * sizeof entries[0]) == 0, "it is the code of the same");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    recorder_entry_t entries[FRAME_CODE_ENTRIES_MAX];

    if (size >= 1U) {
        const uint32_t count = data[0];

        if (frame_code_decode(&data[1], (uint32_t)(size - 1U), entries, count)) {
            HOLDS((count >= 1U) && (count <= FRAME_CODE_ENTRIES_MAX), "a number that there is");
            comes_back(entries, count);
        }
    }
    return 0;
}
