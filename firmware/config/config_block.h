/* SPDX-License-Identifier: MIT */
/*
 * A configuration block: the configuration of a drive, as a file and the flash store it and as a
 * line carries it.
 *
 * Its bytes are 32-bit words, the lowest byte first, in the order of config_block_t:
 *
 *     magic, version, length   what it is
 *     schema, board            which images accept it
 *     about                    facts about the motor that the integers do not contain: pole pairs,
 *                              highest speed, the names
 *     configuration            drive_cfg_t, with the CRC by which config_guard.h guards it
 *     CRC-32                   of all words before it (crc32.h)
 *
 * schema: a hash of paths, offsets, types and quantities of the rows of cfg.def. board: a hash of
 * the facts of the board that are compiled into an image. nfconfig computes both in the same way
 * for a block and for the header of an image. They agree if both were made from the same cfg.def
 * and the same board.
 *
 * On all machines that share a configuration, a config_block_t in memory has the bytes of the block
 * (config_guard.h says why). The functions below read and write a word of it; no other code knows
 * the layout.
 *
 * Pure functions, for the background and for the PC. They accept any bytes.
 */
#ifndef CONFIG_BLOCK_H
#define CONFIG_BLOCK_H

#include "drive_cfg.h"

#include <stdbool.h>
#include <stdint.h>

#define CONFIG_BLOCK_MAGIC (0x4243464EU) /* "NFCB" */
#define CONFIG_BLOCK_VERSION (2U)
#define CONFIG_BLOCK_NAME_BYTES (96U)

/* Two hashes. An image accepts a block only if both are equal in image and block. */
typedef struct {
    uint32_t schema;
    uint32_t board;
} config_identity_t;

/* Facts about the motor that the integers do not contain. */
typedef struct {
    uint32_t pole_pairs;   /* 1…50 */
    int32_t speed_max_rpm; /* highest speed of the shaft, in either direction, 1…200000 */
    /*
     * 1: the motor is an example of the project, so it is not known which motor is connected;
     * otherwise 0
     */
    uint32_t is_example;
    /* names of motor, board and tuning: text, then zeros; the last byte is always 0 */
    char name[CONFIG_BLOCK_NAME_BYTES];
} config_about_t;

typedef struct {
    uint32_t magic;
    uint32_t version;
    uint32_t words; /* length of the block, with its CRC */
    config_identity_t identity;
    config_about_t about;
    drive_cfg_t cfg;
    uint32_t crc;
} config_block_t;

#define CONFIG_BLOCK_BYTES ((uint32_t)sizeof(config_block_t))
#define CONFIG_BLOCK_WORDS (CONFIG_BLOCK_BYTES / 4U)

typedef enum {
    CONFIG_BLOCK_GOOD = 0,
    CONFIG_BLOCK_NO_BLOCK,      /* the magic number differs: this is not a block */
    CONFIG_BLOCK_OTHER_VERSION, /* the layout has another version */
    CONFIG_BLOCK_OTHER_LENGTH,
    CONFIG_BLOCK_BROKEN, /* the CRC does not match */
    CONFIG_BLOCK_OTHER_SCHEMA,
    CONFIG_BLOCK_OTHER_BOARD,
    CONFIG_BLOCK_BAD_SETTING, /* out of its range, or against a rule of config_check.h */
    /*
     * the block protects less than the image, see config_ceiling.h; config_block_check() does not
     * check this
     */
    CONFIG_BLOCK_ABOVE_CEILING
} config_block_fault_t;

/*
 * What is wrong with a block. found and expected are the numbers that differ. If a setting is
 * wrong, both are 0 and `setting` is its path; else `setting` is NULL.
 */
typedef struct {
    config_block_fault_t fault;
    uint32_t found;
    uint32_t expected;
    const char *setting; /* a constant string */
} config_block_verdict_t;

/*
 * Makes the block of a configuration for images of `identity`. The crc of the configuration must be
 * right. about->name is copied up to its 0; what does not fit is cut off.
 */
void config_block_make(config_block_t *block, const config_identity_t *identity,
                       const config_about_t *about, const drive_cfg_t *cfg);

/* Copies `from`, which ends with a 0, into a name. What does not fit is cut off. */
void config_block_name(char to[CONFIG_BLOCK_NAME_BYTES], const char *from);

/* Returns word `at` of the block; 0 when `at` is not below CONFIG_BLOCK_WORDS. */
uint32_t config_block_word(const config_block_t *block, uint32_t at);

/* Sets word `at` of the block; does nothing when `at` is not below CONFIG_BLOCK_WORDS. */
void config_block_set_word(config_block_t *block, uint32_t at, uint32_t word);

/*
 * Write the block as CONFIG_BLOCK_BYTES bytes, and read it from them. They do not check the block.
 */
void config_block_encode(const config_block_t *block, uint8_t *bytes);
void config_block_decode(config_block_t *block, const uint8_t *bytes);

/*
 * Checks whether an image of `expected` may run with a block. The order is: magic, version, length,
 * CRC, schema, board, the facts in `about`, the settings of cfg.def, the CRC of the configuration.
 * The verdict names the first one that is wrong.
 */
config_block_verdict_t config_block_check(const config_block_t *block,
                                          const config_identity_t *expected);

#endif
