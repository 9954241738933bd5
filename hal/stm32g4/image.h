/* SPDX-License-Identifier: MIT */
/*
 * Checks whether the flash still holds the image that was built. The build writes a CRC-32 of all
 * words of the image after them (seal.py). The chip's CRC unit computes it again, RM0440 16.
 */
#ifndef IMAGE_H
#define IMAGE_H

#include <stdbool.h>

/* Checks the whole image, in 3 ms at most. Call once, before the background runs. */
bool image_is_whole(void);

/*
 * Checks the next two words, round after round. False when a round ends with a wrong CRC. Context:
 * background.
 */
bool image_step(void);

#endif
