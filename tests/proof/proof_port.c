/* SPDX-License-Identifier: MIT */
#include "proof_port.h"

#include "port/fx_plain.h"
#include "port/fx_port.h"
#include "port/ring.h"

proof_word_t *const proof_saturations[7] = {fx_sat14, fx_sat15, fx_sat16, fx_sat27,
                                            fx_sat28, fx_sat30, fx_usat15};

int32_t proof_signed(uint32_t x)
{
    return fx_signed(x);
}

uint32_t proof_unsigned(int32_t x)
{
    return fx_unsigned(x);
}

int64_t proof_signed64(uint64_t x)
{
    return fx_signed64(x);
}

uint64_t proof_unsigned64(int64_t x)
{
    return fx_unsigned64(x);
}

int32_t proof_approach(int32_t from, int32_t to, uint32_t shift)
{
    return fx_approach(from, to, shift);
}

int32_t proof_mla_32x16(int32_t sum, int32_t a, int32_t b)
{
    return fx_mla_32x16(sum, a, b);
}

uint32_t proof_leading_zeros(uint32_t x)
{
    return fx_leading_zeros(x);
}

size_t proof_entries_between(const recorder_entry_t *first, const recorder_entry_t *end)
{
    return ring_entries_between(first, end);
}

bool proof_is_within(const recorder_entry_t *at, const recorder_entry_t *stop, uint32_t span)
{
    return ring_is_within(at, stop, span);
}
