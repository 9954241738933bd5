/* SPDX-License-Identifier: MIT */
/*
 * Text of the console: words and numbers into a buffer of fixed size. What does not fit is cut off,
 * and a line that is cut keeps its end.
 */
#ifndef TEXT_H
#define TEXT_H

#include <stdbool.h>
#include <stdint.h>

#define TEXT_MAX (512U)

typedef struct {
    uint32_t length;
    char characters[TEXT_MAX];
} text_t;

/* Append a string that ends with 0. */
void text_add(text_t *text, const char *string);

/*
 * Append CR and LF. There is room for them behind whatever text_add() has added. A second end does
 * not fit then, and is left out.
 */
void text_end_line(text_t *text);

/* Append a number with 0 to 6 decimals: 12345 with 2 is "123.45". */
void text_number(text_t *text, int32_t value, uint32_t decimals);

/* Append the eight digits of a hexadecimal number, capital letters. */
void text_hex(text_t *text, uint32_t value);

/*
 * Returns the CRC-32 (crc32.h) of so many characters from `characters` on, behind what `before` is
 * of; CRC32_START: of nothing. As crc32_byte() it is to be complemented where it is shown. For the
 * sender and the reader of lines.
 */
uint32_t text_crc(uint32_t before, const char *characters, uint32_t length);

/* What follows `start` in `string`; NULL when the string does not start so. */
const char *text_after(const char *string, const char *start);

/*
 * A whole decimal number, with a sign or without, and nothing behind it. False, and nothing done,
 * for anything else and beyond ±999999999.
 */
bool text_to_number(const char *string, int32_t *value);

/*
 * A decimal number in millionths, with a sign or without, up to three digits, and behind a point up
 * to six more. False, and nothing done, for anything else.
 */
bool text_to_millionths(const char *string, int32_t *value);

#endif
