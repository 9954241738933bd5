/* SPDX-License-Identifier: MIT */
/*
 * Whether the flash still holds the image that was built: a CRC-32 of all its words, which the
 * build writes behind them (seal.py). The chip's CRC unit computes it, RM0440 16.
 */
#ifndef IMAGE_H
#define IMAGE_H

#include <stdbool.h>

/* Over the whole image, 3 ms at most. Call once, before the background runs. */
bool image_is_whole(void);

/*
 * The next two words, round after round. False when a round ends with another CRC. Context:
 * background.
 */
bool image_step(void);

#endif
