/* SPDX-License-Identifier: MIT */
#include "text.h"

#include "crc32.h"

#include <stddef.h>

#define DIGITS_MAX (10U) /* digits of 2^32 − 1 */
#define INPUT_DIGITS (9U)
#define WHOLE_DIGITS (3U) /* three digits and six decimals fit in 32 bits */
#define MILLIONTHS_DIGITS (6U)
/* characters that text_add() always leaves free */
#define LINE_END (2U)

#define FIRST_PIECE (0x80U)

static void add_character(text_t *text, char c)
{
    if (text->length < (TEXT_MAX - LINE_END)) {
        text->characters[text->length] = c;
        text->length++;
    }
}

void text_end_line(text_t *text)
{
    if (text->length <= (TEXT_MAX - LINE_END)) {
        text->characters[text->length] = '\r';
        text->characters[text->length + 1U] = '\n';
        text->length += LINE_END;
    }
}

const char *text_piece(char c)
{
    static const char *const pieces[] = {
#define TEXT_PIECE(piece) piece,
    // cppcheck-suppress misra-c2012-20.1 ; D5: the rows are those of the file
#include "text_pieces.def"
    };
    const uint32_t code = (uint8_t)c;
    const uint32_t number = code - FIRST_PIECE;
    const char *piece = NULL;

    if (code >= FIRST_PIECE) {
        piece = (number < (sizeof(pieces) / sizeof(pieces[0]))) ? pieces[number] : "";
    }
    return piece;
}

static void add_plain(text_t *text, const char *string)
{
    for (uint32_t k = 0U; string[k] != '\0'; k++) {
        add_character(text, string[k]);
    }
}

void text_add(text_t *text, const char *string)
{
    for (uint32_t k = 0U; string[k] != '\0'; k++) {
        const char *const piece = text_piece(string[k]);

        if (piece == NULL) {
            add_character(text, string[k]);
        } else {
            add_plain(text, piece);
        }
    }
}

static uint32_t magnitude_of(int32_t value)
{
    const uint32_t bits = (uint32_t)value;

    return (value < 0) ? (0U - bits) : bits;
}

void text_number(text_t *text, int32_t value, uint32_t decimals)
{
    static const char figures[] = "0123456789";
    char reversed[DIGITS_MAX];
    uint32_t count = 0U;
    uint32_t rest = magnitude_of(value);

    do {
        reversed[count] = figures[rest % 10U];
        rest /= 10U;
        count++;
    } while ((rest > 0U) || (count <= decimals));
    if (value < 0) {
        add_character(text, '-');
    }
    while (count > 0U) {
        count--;
        add_character(text, reversed[count]);
        if ((count == decimals) && (decimals > 0U)) {
            add_character(text, '.');
        }
    }
}

void text_hex(text_t *text, uint32_t value)
{
    static const char figures[] = "0123456789ABCDEF";

    for (uint32_t shift = 32U; shift > 0U; shift -= 4U) {
        add_character(text, figures[(value >> (shift - 4U)) & 0xFU]);
    }
}

uint32_t text_crc(uint32_t before, const char *characters, uint32_t length)
{
    uint32_t crc = before;

    for (uint32_t k = 0U; k < length; k++) {
        crc = crc32_byte(crc, (uint8_t)characters[k]);
    }
    return crc;
}

const char *text_after(const char *string, const char *start)
{
    uint32_t k = 0U;

    while ((start[k] != '\0') && (string[k] == start[k])) {
        k++;
    }
    return (start[k] == '\0') ? &string[k] : NULL;
}

/*
 * Reads at most `most` decimal digits of `string`, from index `from` on, and appends them to *sum:
 * *sum = 10 · *sum + digit. Returns the index after the last digit.
 */
static uint32_t add_digits(const char *string, uint32_t from, uint32_t most, int32_t *sum)
{
    uint32_t k = from;

    while ((string[k] >= '0') && (string[k] <= '9') && ((k - from) < most)) {
        *sum = (*sum * 10) + ((int32_t)string[k] - (int32_t)'0');
        k++;
    }
    return k;
}

bool text_to_millionths(const char *string, int32_t *value)
{
    const bool negative = string[0] == '-';
    const uint32_t first = (negative || (string[0] == '+')) ? 1U : 0U;
    int32_t sum = 0;
    const uint32_t point = add_digits(string, first, WHOLE_DIGITS, &sum);
    uint32_t end = point;
    uint32_t decimals = 0U;
    bool good;

    if (string[point] == '.') {
        end = add_digits(string, point + 1U, MILLIONTHS_DIGITS, &sum);
        decimals = (end - point) - 1U;
    }
    for (uint32_t k = decimals; k < MILLIONTHS_DIGITS; k++) {
        sum *= 10;
    }
    good = (point > first) && ((decimals > 0U) || (end == point)) && (string[end] == '\0');
    if (good) {
        *value = negative ? -sum : sum;
    }
    return good;
}

bool text_to_number(const char *string, int32_t *value)
{
    const bool negative = string[0] == '-';
    const uint32_t first = (negative || (string[0] == '+')) ? 1U : 0U;
    int32_t sum = 0;
    const uint32_t end = add_digits(string, first, INPUT_DIGITS, &sum);
    const bool good = (end > first) && (string[end] == '\0');

    if (good) {
        *value = negative ? -sum : sum;
    }
    return good;
}
