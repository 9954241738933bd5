/* SPDX-License-Identifier: MIT */
/* The functions of tests/proof/port under other names, beside those of the firmware. */
#ifndef PROOF_PORT_H
#define PROOF_PORT_H

#include "recorder_entry.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef int32_t proof_word_t(int32_t x);

/* fx_sat14, 15, 16, 27, 28, 30 and fx_usat15, in the order of test_proof_port.c. */
extern proof_word_t *const proof_saturations[7];

int32_t proof_signed(uint32_t x);
uint32_t proof_unsigned(int32_t x);
int64_t proof_signed64(uint64_t x);
uint64_t proof_unsigned64(int64_t x);
int32_t proof_approach(int32_t from, int32_t to, uint32_t shift);
int32_t proof_mla_32x16(int32_t sum, int32_t a, int32_t b);
uint32_t proof_leading_zeros(uint32_t x);
size_t proof_entries_between(const recorder_entry_t *first, const recorder_entry_t *end);
bool proof_is_within(const recorder_entry_t *at, const recorder_entry_t *stop, uint32_t span);

#endif
