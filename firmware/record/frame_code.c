/* SPDX-License-Identifier: MIT */
/*
 * The code, in bits. The first bit is the lowest of the first byte, and a number has its lowest bit
 * first.
 *
 *     for each channel    6 bits: 0, it is constant; or 1 + k + 15 · p: the differences from
 *                         prediction p have the Rice parameter k, 0…14
 *     entries up to       1, a change; 0, the frame: for each channel 5 bits with the number of
 *     the first frame     bits of its value, then the value
 *     further entries     a frame is a code for each channel that is not constant; a change begins
 *                         with 11 ones
 *     zeros               to the end of the byte
 *
 * The predictions, all modulo 2^16. v1 is the value before, v2 to v4 are the values before it. At
 * the first frame all four become its value:
 *
 *     0    v1
 *     1    2·v1 − v2
 *     2    v1 + (v2 − v4)/2, rounded down
 *
 * A difference d of 16 bits becomes z = 0, 1, 2, 3, … for 0, −1, 1, −2, … Its Rice code is z >> k
 * ones, a 0 and the lowest k bits of z. If there were 10 ones or more, the code is 10 ones, a 0 and
 * the 16 bits of z instead. A change is coded as its first, second and fourth word.
 *
 * No piece of a code has more than 24 bits, so put_bits() needs only one shift for it.
 */
#include "frame_code.h"

#include <stddef.h>

#define CHANNELS (5U)
#define MODE_BITS (6U)
#define RICE_MAX (14U)
#define RICES (RICE_MAX + 1U)
#define SAMPLE (32U) /* prediction and parameter are chosen from the first 32 entries */
/* the predictions of the first 3 differences have too few values before them */
#define FIRST_ONES (3U)
#define ONES_MAX (10U)
#define ESCAPE_BITS (11U) /* ONES_MAX ones, then 0 before a value, or 1 before a change */
#define ESCAPE_VALUE (0x3FFU)
#define ESCAPE_CHANGE (0x7FFU)
#define LENGTH_BITS (5U)
#define VALUE_BITS (16U)
#define VALUE_MASK (0xFFFFU)
#define SIGN_BIT (0x8000U)
#define MARK_WORD (2U)
#define ENTRY_WORDS (4U)
#define BYTE_BITS (8U)
#define BYTE_MASK (0xFFU)

/* Place of each channel in the entry of a frame. */
static const struct {
    uint32_t word;
    uint32_t shift;
} places[CHANNELS] = {{0U, 0U}, {0U, 16U}, {1U, 0U}, {1U, 16U}, {3U, 16U}};

typedef enum {
    BEFORE,  /* the value before */
    LINE,    /* the line through the two values before */
    SMOOTH,  /* the value before, plus half the step from v4 to v2 */
    CONSTANT /* no prediction; as a number it is the number of predictions */
} prediction_t;

#define PREDICTIONS ((uint32_t)CONSTANT)

/* The prediction of a channel, and the values before it. */
typedef struct {
    prediction_t prediction;
    uint32_t rice;
    uint32_t v1; /* the last value; v2 to v4 are the values before it */
    uint32_t v2;
    uint32_t v3;
    uint32_t v4;
} channel_t;

/* State of the coding or decoding: the channels, and whether the first frame has been coded. */
typedef struct {
    channel_t channels[CHANNELS];
    bool began;
} code_t;

static uint32_t value_of(const recorder_entry_t *entry, uint32_t channel)
{
    return (entry->word[places[channel].word] >> places[channel].shift) & VALUE_MASK;
}

/* Returns 0, 1, 2, 3, … for a difference of 16 bits of 0, −1, 1, −2, … */
static uint32_t fold(uint32_t difference)
{
    const uint32_t all_if_negative = 0U - ((difference >> 15U) & 1U);

    return ((difference << 1U) ^ all_if_negative) & VALUE_MASK;
}

static uint32_t unfold(uint32_t folded)
{
    const uint32_t half = folded >> 1U;

    return ((folded & 1U) != 0U) ? ~half : half;
}

/* Returns half of a difference of 16 bits, rounded down. */
static uint32_t halve(uint32_t difference)
{
    return (((difference ^ SIGN_BIT) & VALUE_MASK) >> 1U) - (SIGN_BIT / 2U);
}

/* Returns the predicted value. Only its lowest 16 bits are valid. */
static uint32_t predict(const channel_t *channel, prediction_t prediction)
{
    uint32_t value = channel->v1;

    if (prediction == LINE) {
        value += channel->v1 - channel->v2;
    } else if (prediction == SMOOTH) {
        value += halve(channel->v2 - channel->v4);
    } else {
        /* the value before */
    }
    return value;
}

static void learn(channel_t *channel, uint32_t value)
{
    channel->v4 = channel->v3;
    channel->v3 = channel->v2;
    channel->v2 = channel->v1;
    channel->v1 = value;
}

static void learn_first(channel_t *channel, uint32_t value)
{
    channel->v1 = value;
    channel->v2 = value;
    channel->v3 = value;
    channel->v4 = value;
}

/* The differences of a channel: their number, and for each prediction the sum of z. */
typedef struct {
    uint32_t count;
    uint32_t z[PREDICTIONS];
} sums_t;

static void add_difference(sums_t *sums, const channel_t *history, uint32_t value)
{
    sums->z[BEFORE] += fold(value - predict(history, BEFORE));
    sums->z[LINE] += fold(value - predict(history, LINE));
    sums->z[SMOOTH] += fold(value - predict(history, SMOOTH));
    sums->count++;
}

/*
 * Limits the sums while the channel has at most FIRST_ONES (3) differences: their predictions have
 * too few values before them, so the sums are too large. Each of these differences counts at most
 * as much as the longest code has bits.
 */
static void limit_first(sums_t *sums)
{
    const uint32_t most = sums->count * (ESCAPE_BITS + VALUE_BITS);

    for (uint32_t k = 0U; (sums->count <= FIRST_ONES) && (k < PREDICTIONS); k++) {
        sums->z[k] = (sums->z[k] < most) ? sums->z[k] : most;
    }
}

/* Returns the first frame of these entries, or NULL when all are changes. */
static const recorder_entry_t *first_frame(const recorder_entry_t *entries, uint32_t count)
{
    const recorder_entry_t *found = NULL;

    for (uint32_t k = 0U; (k < count) && (found == NULL); k++) {
        found = recorder_entry_is_change(&entries[k]) ? NULL : &entries[k];
    }
    return found;
}

/* Sets in `bits` each bit in which any frame differs from the first one. */
static void find_changing_bits(const recorder_entry_t *entries, uint32_t count,
                               recorder_entry_t *bits)
{
    const recorder_entry_t *const first = first_frame(entries, count);

    *bits = (recorder_entry_t){{0U, 0U, 0U, 0U}};
    for (uint32_t k = 0U; (k < count) && (first != NULL); k++) {
        if (!recorder_entry_is_change(&entries[k])) {
            bits->word[0] |= entries[k].word[0] ^ first->word[0];
            bits->word[1] |= entries[k].word[1] ^ first->word[1];
            bits->word[3] |= entries[k].word[3] ^ first->word[3];
        }
    }
}

static sums_t sum_up(const recorder_entry_t *entries, uint32_t count, uint32_t channel)
{
    const uint32_t word = places[channel].word;
    const uint32_t shift = places[channel].shift;
    const recorder_entry_t *const first = first_frame(entries, count);
    channel_t history = {.prediction = CONSTANT};
    sums_t sums = {0U, {0U, 0U, 0U}};

    if (first != NULL) {
        learn_first(&history, value_of(first, channel));
    }
    for (uint32_t k = 0U; k < count; k++) {
        if (!recorder_entry_is_change(&entries[k]) && (&entries[k] != first)) {
            const uint32_t value = (entries[k].word[word] >> shift) & VALUE_MASK;

            add_difference(&sums, &history, value);
            limit_first(&sums);
            learn(&history, value);
        }
    }
    return sums;
}

/*
 * Returns the number of bits of `count` codes with parameter k, from the sum of their z. The error
 * is less than a bit per code.
 */
static uint32_t cost_of(uint32_t count, uint32_t sum, uint32_t k)
{
    return (count * (k + 1U)) + (sum >> k);
}

/* Returns the k with the least cost. The cost falls up to this k and rises after it. */
static uint32_t best_rice(uint32_t count, uint32_t sum)
{
    uint32_t k = 0U;

    while ((k < RICE_MAX) && (cost_of(count, sum, k + 1U) < cost_of(count, sum, k))) {
        k++;
    }
    return k;
}

/* Chooses the prediction and the parameter with the least cost. */
static void plan_channel(channel_t *channel, const sums_t *sums)
{
    uint32_t least = UINT32_MAX;

    for (uint32_t k = 0U; k < PREDICTIONS; k++) {
        const uint32_t rice = best_rice(sums->count, sums->z[k]);
        const uint32_t cost = cost_of(sums->count, sums->z[k], rice);

        if (cost < least) {
            least = cost;
            channel->prediction = (prediction_t)k;
            channel->rice = rice;
        }
    }
}

/*
 * Chooses the code of each channel. The code of the first channel carries the escape of a change.
 * So this channel counts as constant only if there is no change.
 */
static void plan_code(code_t *code, const recorder_entry_t *entries, uint32_t count)
{
    recorder_entry_t changing;
    bool has_change = false;

    find_changing_bits(entries, count, &changing);
    for (uint32_t k = 0U; k < count; k++) {
        has_change = has_change || recorder_entry_is_change(&entries[k]);
    }
    for (uint32_t channel = 0U; channel < CHANNELS; channel++) {
        const bool has_escape = has_change && (channel == 0U);

        code->channels[channel] = (channel_t){.prediction = CONSTANT};
        if (has_escape || (value_of(&changing, channel) != 0U)) {
            const uint32_t sample = (count < SAMPLE) ? count : SAMPLE;
            const sums_t sums = sum_up(entries, sample, channel);

            plan_channel(&code->channels[channel], &sums);
        }
    }
    code->began = false;
}

/* A writer of bits. Bytes beyond `room` are counted but not written. */
typedef struct {
    uint8_t *bytes;
    uint32_t room;
    uint32_t length; /* whole bytes */
    uint32_t bits;   /* bits of the last byte, which is not whole yet */
    uint32_t count;
} bits_out_t;

/* Puts at most 24 bits; the bits of `value` above them must be 0. */
static void put_bits(bits_out_t *writer, uint32_t value, uint32_t count)
{
    writer->bits |= value << writer->count;
    writer->count += count;
    while (writer->count >= BYTE_BITS) {
        if (writer->length < writer->room) {
            writer->bytes[writer->length] = (uint8_t)(writer->bits & BYTE_MASK);
        }
        writer->length++;
        writer->bits >>= BYTE_BITS;
        writer->count -= BYTE_BITS;
    }
}

static void put_zeros_to_end(bits_out_t *writer)
{
    if (writer->count > 0U) {
        put_bits(writer, 0U, BYTE_BITS - writer->count);
    }
}

static bool has_room(const bits_out_t *writer)
{
    return (writer->length + ((writer->count > 0U) ? 1U : 0U)) <= writer->room;
}

static uint32_t ones(uint32_t count)
{
    return ((uint32_t)1U << count) - 1U;
}

static void put_rice(bits_out_t *writer, uint32_t folded, uint32_t rice)
{
    const uint32_t quotient = folded >> rice;

    if (quotient < ONES_MAX) {
        const uint32_t rest = folded & ones(rice);

        put_bits(writer, ones(quotient) | (rest << (quotient + 1U)), quotient + 1U + rice);
    } else {
        put_bits(writer, ESCAPE_VALUE, ESCAPE_BITS);
        put_bits(writer, folded, VALUE_BITS);
    }
}

static void put_word(bits_out_t *writer, uint32_t word)
{
    put_bits(writer, word & VALUE_MASK, VALUE_BITS);
    put_bits(writer, word >> VALUE_BITS, VALUE_BITS);
}

static void code_change(bits_out_t *writer, const code_t *code, const recorder_entry_t *entry)
{
    if (code->began) {
        put_bits(writer, ESCAPE_CHANGE, ESCAPE_BITS);
    } else {
        put_bits(writer, 1U, 1U);
    }
    put_word(writer, entry->word[0]);
    put_word(writer, entry->word[1]);
    put_word(writer, entry->word[3]);
}

static void code_first(bits_out_t *writer, code_t *code, const recorder_entry_t *entry)
{
    put_bits(writer, 0U, 1U);
    for (uint32_t channel = 0U; channel < CHANNELS; channel++) {
        const uint32_t value = value_of(entry, channel);
        uint32_t length = 0U;

        while ((value >> length) != 0U) {
            length++;
        }
        put_bits(writer, length, LENGTH_BITS);
        put_bits(writer, value, length);
        learn_first(&code->channels[channel], value);
    }
}

static void code_frame(bits_out_t *writer, code_t *code, const recorder_entry_t *entry)
{
    for (uint32_t k = 0U; k < CHANNELS; k++) {
        channel_t *const channel = &code->channels[k];

        if (channel->prediction != CONSTANT) {
            const uint32_t value = value_of(entry, k);

            put_rice(writer, fold(value - predict(channel, channel->prediction)), channel->rice);
            learn(channel, value);
        }
    }
}

static void put_entry(bits_out_t *writer, code_t *code, const recorder_entry_t *entry)
{
    if (recorder_entry_is_change(entry)) {
        code_change(writer, code, entry);
    } else if (code->began) {
        code_frame(writer, code, entry);
    } else {
        code_first(writer, code, entry);
        code->began = true;
    }
}

static uint32_t mode_of(const channel_t *channel)
{
    return (channel->prediction == CONSTANT)
               ? 0U
               : ((((uint32_t)channel->prediction * RICES) + channel->rice) + 1U);
}

uint32_t frame_code_encode(const recorder_entry_t *entries, uint32_t count, uint8_t *bytes,
                           uint32_t room, uint32_t *length)
{
    code_t code;
    bits_out_t writer = {.bytes = bytes, .room = room};
    bits_out_t whole;
    uint32_t done = 0U;

    plan_code(&code, entries, count);
    for (uint32_t channel = 0U; channel < CHANNELS; channel++) {
        put_bits(&writer, mode_of(&code.channels[channel]), MODE_BITS);
    }
    whole = writer;
    while ((done < count) && has_room(&writer)) {
        put_entry(&writer, &code, &entries[done]);
        if (has_room(&writer)) {
            whole = writer;
            done++;
        }
    }
    put_zeros_to_end(&whole);
    *length = whole.length;
    return done;
}

typedef struct {
    const uint8_t *bytes;
    uint32_t length; /* length of the code in bits */
    uint32_t at;
    bool is_bad; /* the code is wrong: a bit beyond its end was read, or bits have no meaning */
} bits_in_t;

static uint32_t get_bit(bits_in_t *reader)
{
    uint32_t bit = 0U;

    if (reader->at < reader->length) {
        bit = ((uint32_t)reader->bytes[reader->at / BYTE_BITS] >> (reader->at % BYTE_BITS)) & 1U;
        reader->at++;
    } else {
        reader->is_bad = true;
    }
    return bit;
}

static uint32_t get_bits(bits_in_t *reader, uint32_t count)
{
    uint32_t value = 0U;

    for (uint32_t k = 0U; k < count; k++) {
        value |= get_bit(reader) << k;
    }
    return value;
}

/*
 * Reads the ones up to the next 0, and this 0 too. After ONES_MAX ones it stops and reads no 0.
 * Returns the number of ones.
 */
static uint32_t get_ones(bits_in_t *reader)
{
    uint32_t count = 0U;

    while ((count < ONES_MAX) && (get_bit(reader) != 0U)) {
        count++;
    }
    return count;
}

/* Reads the rest of a Rice code after its `quotient` ones. Returns z. */
static uint32_t get_rice(bits_in_t *reader, uint32_t quotient, uint32_t rice)
{
    uint32_t folded;

    if (quotient < ONES_MAX) {
        folded = (quotient << rice) | get_bits(reader, rice);
    } else {
        folded = get_bits(reader, VALUE_BITS);
    }
    return folded;
}

static void get_change(bits_in_t *reader, recorder_entry_t *entry)
{
    entry->word[0] = get_bits(reader, 2U * VALUE_BITS);
    entry->word[1] = get_bits(reader, 2U * VALUE_BITS);
    entry->word[MARK_WORD] = RECORDER_CHANGE_MARK;
    entry->word[3] = get_bits(reader, 2U * VALUE_BITS);
}

static void set_value(recorder_entry_t *entry, uint32_t channel, uint32_t value)
{
    entry->word[places[channel].word] |= value << places[channel].shift;
}

static void get_first(bits_in_t *reader, code_t *code, recorder_entry_t *entry)
{
    for (uint32_t channel = 0U; channel < CHANNELS; channel++) {
        const uint32_t length = get_bits(reader, LENGTH_BITS);
        const bool fits = length <= VALUE_BITS;
        const uint32_t value = fits ? get_bits(reader, length) : 0U;

        reader->is_bad = reader->is_bad || !fits;
        learn_first(&code->channels[channel], value);
        set_value(entry, channel, value);
    }
}

/*
 * Reads the next value of a channel that is not constant. Returns true when the escape of a change
 * stands in its place.
 */
static bool get_value(bits_in_t *reader, channel_t *channel)
{
    const uint32_t quotient = get_ones(reader);
    const bool changes = (quotient == ONES_MAX) && (get_bit(reader) != 0U);

    if (!changes) {
        const uint32_t folded = get_rice(reader, quotient, channel->rice);

        learn(channel, (predict(channel, channel->prediction) + unfold(folded)) & VALUE_MASK);
    }
    return changes;
}

/*
 * Reads the next frame. Returns true when a change stands in its place. Only the first channel
 * carries the escape of a change.
 */
static bool get_next(bits_in_t *reader, code_t *code, recorder_entry_t *entry)
{
    bool changes = false;

    for (uint32_t k = 0U; (k < CHANNELS) && !changes; k++) {
        channel_t *const channel = &code->channels[k];

        changes = (channel->prediction != CONSTANT) && get_value(reader, channel);
        reader->is_bad = reader->is_bad || (changes && (k != 0U));
        set_value(entry, k, channel->v1);
    }
    return changes;
}

static void get_entry(bits_in_t *reader, code_t *code, recorder_entry_t *entry)
{
    bool changes;

    *entry = (recorder_entry_t){{0U, 0U, 0U, 0U}};
    if (code->began) {
        changes = get_next(reader, code, entry);
    } else {
        changes = get_bit(reader) != 0U;
        if (!changes) {
            get_first(reader, code, entry);
            code->began = true;
        }
    }
    if (changes) {
        get_change(reader, entry);
    }
}

static void get_modes(bits_in_t *reader, code_t *code)
{
    for (uint32_t k = 0U; k < CHANNELS; k++) {
        const uint32_t mode = get_bits(reader, MODE_BITS);
        channel_t *const channel = &code->channels[k];

        *channel = (channel_t){.prediction = CONSTANT};
        reader->is_bad = reader->is_bad || (mode > (PREDICTIONS * RICES));
        if (mode > 0U) {
            const uint32_t prediction = (mode - 1U) / RICES;

            channel->prediction = (prediction_t)prediction;
            channel->rice = (mode - 1U) % RICES;
        }
    }
    code->began = false;
}

/* Whether less than a byte is left and all its bits are zeros. */
static bool ends_here(bits_in_t *reader)
{
    const uint32_t left = reader->length - reader->at;

    return (left < BYTE_BITS) && (get_bits(reader, left) == 0U);
}

bool frame_code_decode(const uint8_t *bytes, uint32_t length, recorder_entry_t *entries,
                       uint32_t count)
{
    const bool is_count = (count >= 1U) && (count <= FRAME_CODE_ENTRIES_MAX);
    bits_in_t reader = {.bytes = bytes, .length = length * BYTE_BITS};
    code_t code;

    get_modes(&reader, &code);
    for (uint32_t k = 0U; is_count && !reader.is_bad && (k < count); k++) {
        get_entry(&reader, &code, &entries[k]);
    }
    return is_count && !reader.is_bad && ends_here(&reader);
}
