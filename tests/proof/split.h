/* SPDX-License-Identifier: MIT */
/*
 * Case distinctions for the proof: all words x in 256 blocks of 2^24, or an angle in 64 sectors.
 * Eva goes through the cases one by one where the firmware says `assert BLOCKS(x)`, which is true
 * of every word and proven like any other assertion.
 */
#define BLOCKS_4(x, at) \
    ((at) <= (x) <= (at) + 0xFFFFFF || (at) + 0x1000000 <= (x) <= (at) + 0x1FFFFFF || \
     (at) + 0x2000000 <= (x) <= (at) + 0x2FFFFFF || (at) + 0x3000000 <= (x) <= (at) + 0x3FFFFFF)
#define BLOCKS_16(x, at) \
    (BLOCKS_4(x, at) || BLOCKS_4(x, (at) + 0x4000000) || BLOCKS_4(x, (at) + 0x8000000) || \
     BLOCKS_4(x, (at) + 0xC000000))
#define BLOCKS_64(x, at) \
    (BLOCKS_16(x, at) || BLOCKS_16(x, (at) + 0x10000000) || BLOCKS_16(x, (at) + 0x20000000) || \
     BLOCKS_16(x, (at) + 0x30000000))
#define BLOCKS(x) \
    (BLOCKS_64(x, 0) || BLOCKS_64(x, 0x40000000) || BLOCKS_64(x, 0x80000000) || \
     BLOCKS_64(x, 0xC0000000))

#define SECTORS_4(x, at) \
    ((at) <= (x) <= (at) + 0x3FFFFFF || (at) + 0x4000000 <= (x) <= (at) + 0x7FFFFFF || \
     (at) + 0x8000000 <= (x) <= (at) + 0xBFFFFFF || (at) + 0xC000000 <= (x) <= (at) + 0xFFFFFFF)
#define SECTORS_16(x, at) \
    (SECTORS_4(x, at) || SECTORS_4(x, (at) + 0x10000000) || SECTORS_4(x, (at) + 0x20000000) || \
     SECTORS_4(x, (at) + 0x30000000))
#define SECTORS(x) \
    (SECTORS_16(x, 0) || SECTORS_16(x, 0x40000000) || SECTORS_16(x, 0x80000000) || \
     SECTORS_16(x, 0xC0000000))

/*
 * In place of inlining.h: of a function that has an attribute of gcc and returns a structure, Eva
 * does not know what it returns. What is inlined changes no value.
 */
#define INLINING_H
#define INLINES_ALL
#define NEVER_INLINED
#define RARE
