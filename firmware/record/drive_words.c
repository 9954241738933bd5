/* SPDX-License-Identifier: MIT */
#include "drive_words.h"

#include <stddef.h>

#define WORD_BYTES (4U)
#define FNV_PRIME (16777619U)

/* A part of drive_t without padding: whole words, or one byte that becomes a word. */
typedef struct {
    uint32_t offset;
    uint32_t bytes;
} piece_t;

#define OFFSET(member) ((uint32_t)offsetof(drive_t, member))
#define BYTE(member) {OFFSET(member), 1U}
#define LONG(member) {OFFSET(member), 2U * WORD_BYTES}
/* All words from one member to another, both included. */
#define WORDS(first, last) {OFFSET(first), (OFFSET(last) + WORD_BYTES) - OFFSET(first)}

static const piece_t pieces[] = {
    WORDS(state, state),
    BYTE(slow_count),
    WORDS(limits, tick),
    WORDS(modulator, modulator.inverse_bus_q12),
    WORDS(control, control.voltage.q),
    LONG(rotor.position),
    WORDS(rotor.observer, rotor.residual),
    WORDS(rotor.angle_sensor, rotor.angle_sensor.check),
    BYTE(rotor.source),
    BYTE(rotor.followed),
    BYTE(rotor.aligned),
    BYTE(rotor.failed),
    WORDS(sensors, sensors.sums.noise),
    BYTE(voltage_drive.active),
    WORDS(voltage_drive.calm_periods, voltage_drive.damping.mean_q30.q),
    WORDS(motion.position_loop, motion.speed_loop.inertia_q17),
    BYTE(motion.mode),
    WORDS(motion.torque_range, motion.torque_loop.end),
    WORDS(motor.model, motor.model.check_gains),
    BYTE(motor.identified),
    WORDS(vector, vector.current_mean.q),
    WORDS(start.flying_start, start.flying_start.first.beta),
    BYTE(start.flying_start.gates),
    WORDS(start.flying_start.speed, start.align.tick),
    BYTE(start.align.backwards),
    WORDS(start.align.current_ref, watch.oscillation.motion),
    BYTE(watch.oscillation.falls),
    WORDS(watch.oscillation.extreme, scene.motoring),
};

#define PIECES ((uint32_t)(sizeof(pieces) / sizeof(pieces[0])))

static uint32_t words_of(const piece_t *piece)
{
    return (piece->bytes + WORD_BYTES - 1U) / WORD_BYTES;
}

/*
 * Returns the piece that contains word `at` and makes `at` relative to that piece; NULL beyond the
 * last.
 */
static const piece_t *find(uint32_t *at)
{
    const piece_t *found = NULL;

    for (uint32_t k = 0U; (k < PIECES) && (found == NULL); k++) {
        const uint32_t words = words_of(&pieces[k]);

        if (*at < words) {
            found = &pieces[k];
        } else {
            *at -= words;
        }
    }
    return found;
}

static uint32_t bytes_of(const piece_t *piece)
{
    return (piece->bytes < WORD_BYTES) ? piece->bytes : WORD_BYTES;
}

static uint32_t load(const uint8_t *from, uint32_t bytes)
{
    uint32_t word = 0U;

    for (uint32_t k = 0U; k < bytes; k++) {
        word |= (uint32_t)from[k] << (8U * k);
    }
    return word;
}

uint32_t drive_words_count(void)
{
    uint32_t count = 0U;

    for (uint32_t k = 0U; k < PIECES; k++) {
        count += words_of(&pieces[k]);
    }
    return count;
}

uint32_t drive_words_get(const drive_t *drive, uint32_t at)
{
    const uint8_t *const bytes = (const uint8_t *)drive;
    uint32_t in_piece = at;
    const piece_t *const piece = find(&in_piece);

    return (piece == NULL) ? 0U
                           : load(&bytes[piece->offset + (in_piece * WORD_BYTES)], bytes_of(piece));
}

void drive_words_set(drive_t *drive, uint32_t at, uint32_t word)
{
    uint8_t *const bytes = (uint8_t *)drive;
    uint32_t in_piece = at;
    const piece_t *const piece = find(&in_piece);

    if (piece != NULL) {
        for (uint32_t k = 0U; k < bytes_of(piece); k++) {
            const uint32_t byte = (word >> (8U * k)) & 0xFFU;

            bytes[piece->offset + (in_piece * WORD_BYTES) + k] = (uint8_t)byte;
        }
    }
}

static uint32_t mix(uint32_t before, uint32_t word)
{
    uint32_t hash = before;

    for (uint32_t k = 0U; k < WORD_BYTES; k++) {
        hash = (hash ^ ((word >> (8U * k)) & 0xFFU)) * FNV_PRIME;
    }
    return hash;
}

/* Hashes the words `first` to `end` − 1 of a piece. */
static uint32_t hash_words(uint32_t before, const drive_t *drive, const piece_t *piece,
                           uint32_t first, uint32_t end)
{
    const uint8_t *const bytes = (const uint8_t *)drive;
    uint32_t hash = before;

    for (uint32_t at = first; at < end; at++) {
        hash = mix(hash, load(&bytes[piece->offset + (at * WORD_BYTES)], bytes_of(piece)));
    }
    return hash;
}

uint32_t drive_words_hash_part(uint32_t before, const drive_t *drive, uint32_t *at, uint32_t count)
{
    uint32_t hash = before;
    uint32_t left = count;
    uint32_t first = *at;
    const piece_t *piece = find(&first);

    while ((piece != NULL) && (left > 0U)) {
        const uint32_t there = words_of(piece) - first;
        const uint32_t taken = (there < left) ? there : left;

        hash = hash_words(hash, drive, piece, first, first + taken);
        left -= taken;
        *at += taken;
        first = *at;
        piece = find(&first);
    }
    return hash;
}

uint32_t drive_words_hash(const drive_t *drive)
{
    uint32_t hash = DRIVE_WORDS_HASH_START;

    for (uint32_t k = 0U; k < PIECES; k++) {
        hash = hash_words(hash, drive, &pieces[k], 0U, words_of(&pieces[k]));
    }
    return hash;
}
