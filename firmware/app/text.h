/* SPDX-License-Identifier: MIT */
/*
 * Writes words and numbers for the console as text into a buffer of fixed size. Text that does not
 * fit is cut off; a line that is cut still ends with CR and LF.
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

/*
 * Constant texts may be packed (text_pieces.def): a character with its highest bit set stands for a
 * piece. Returns this piece, "" for a number that has none, or NULL for any other character.
 * Whoever sends constant texts without text_add() uses it.
 */
const char *text_piece(char c);

/* Append a string that ends with 0. It may be packed. */
void text_add(text_t *text, const char *string);

/*
 * Append CR and LF. text_add() always leaves room for them. If the text is full, a second CR and LF
 * do not fit, and are left out.
 */
void text_end_line(text_t *text);

/* Append a number with 0 to 6 decimals: 12345 with 2 is "123.45". */
void text_number(text_t *text, int32_t value, uint32_t decimals);

/* Append the eight digits of a hexadecimal number, capital letters. */
void text_hex(text_t *text, uint32_t value);

/*
 * Returns the CRC-32 (crc32.h) of `before`, continued over `length` characters. before: CRC32_START
 * for the first characters. Complement the result where it is shown, as with crc32_byte(). Sender
 * and reader of lines use this function.
 */
uint32_t text_crc(uint32_t before, const char *characters, uint32_t length);

/* Returns the part of `string` after `start`; NULL when it does not begin with `start`. */
const char *text_after(const char *string, const char *start);

/*
 * Reads a whole decimal number with or without a sign. Returns false and leaves *value as it is if
 * the string is anything else, or has more than nine digits.
 */
bool text_to_number(const char *string, int32_t *value);

/*
 * Reads a decimal number in millionths: with or without a sign, one to three digits, and up to six
 * more after a point. Returns false and leaves *value as it is if the string is anything else.
 */
bool text_to_millionths(const char *string, int32_t *value);

#endif
