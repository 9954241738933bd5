/* SPDX-License-Identifier: MIT */
/*
 * The messages of the link between a board and a PC, for both sides. docs/link.md says how a
 * conversation goes.
 *
 * A message is type, tag and a body. All numbers are unsigned and have their lowest byte first,
 * unless noted. A message travels as
 *
 *     00  COBS(type, tag, body, CRC-32 of type to body)  00
 *
 * The PC asks one question at a time. The board answers with the type + LINK_ANSWER and the tag of
 * the question. Messages that the board sends unasked have the tag 0. The board answers
 * LINK_REFUSED to a body that is too short or too long for its type; it ignores a frame whose CRC
 * is wrong.
 */
#ifndef LINK_MESSAGES_H
#define LINK_MESSAGES_H

#include <stdint.h>

#define LINK_VERSION (4U)
#define LINK_MESSAGE_BYTES_MAX (160U) /* type, tag, body */
#define LINK_CRC_BYTES (4U)

#define LINK_ANSWER (0x80U)
#define LINK_READ_WORDS_MAX (32U) /* words of a block or a state in one message */
#define LINK_TEXT_MAX (120U)      /* characters of a LINK_TEXT */

/* Questions. */
typedef enum {
    /*
     * version u8, salt u32 (the PC takes another number for each session). Switches the line from
     * the console to the link. Answer: identity, below
     */
    LINK_HELLO = 1,
    LINK_BYE,  /* switches back to the console. Answer: nothing after type and tag */
    LINK_PING, /* keeps the link and the command in force. Answer: health, below */
    /* request u8, mode u8, target s32: as drive_command_t; ticket u32. Answer: verdict */
    LINK_COMMAND,
    /*
     * ticket u32, a line for the console, without its end. Answer: verdict; the text of the console
     * comes as LINK_TEXT
     */
    LINK_LINE,
    /*
     * first word u16, number of words u8: reads the block in force. Answer: first u16, number u8,
     * each word u32
     */
    LINK_READ,
    /*
     * first word u16, number of words u8, each word u32: writes the prepared block. Answer: verdict
     */
    LINK_WRITE,
    /*
     * crc u32: CRC of the configuration in the prepared block. This block becomes the block in
     * force. Answer: verdict
     */
    LINK_APPLY,
    LINK_STORE,    /* stores the block in force in flash. Answer: verdict */
    LINK_DEFAULTS, /* the block of the image becomes the block in force. Answer: verdict */
    /*
     * on u8: 0 ends the stream; any other value starts it, with the newest segment. 1: a message
     * takes as many entries as fit. Above 1: a message takes at most so many entries, for a line
     * that spoils long messages. Answer: verdict
     */
    LINK_STREAM,
    /*
     * segment u32, first word u16, number of words u8: reads the state of the drive before this
     * segment. Answer: segment u32, first u16, number u8, each word u32
     */
    LINK_STATE,
    /*
     * segment u32, first entry u16, number of entries u8: asks for these entries again. Answer: as
     * LINK_FRAMES, with these entries or fewer
     */
    LINK_AGAIN,
    /*
     * part u8, first word u16, number of words u8: reads the black box (box.h). Part 0: the log of
     * faults, fault_log_t; 1: the saved recording, a file of recorder_dump.h. Answer: first u16,
     * number u8, each word u32
     */
    LINK_BOX
} link_question_t;

#define LINK_BOX_LOG (0U)
#define LINK_BOX_RECORDING (1U)

/*
 * A verdict is ticket u32 and a text for a person. The text is empty if the question was carried
 * out, else it is the reason for the refusal. The next command has to carry this ticket
 * (commander.h).
 */

/* Messages that the board sends unasked, and LINK_REFUSED. */
typedef enum {
    LINK_TEXT = 0xC0,    /* text of the console */
    LINK_SEGMENT = 0xC1, /* a segment of the ring begins, below */
    /* segment u32, first entry u16, entries u8, then their code (frame_code.h) */
    LINK_FRAMES = 0xC2,
    /* type u8 of the refused message: the board does not know this type, or the length is wrong */
    LINK_REFUSED = 0xFF
} link_notice_t;

/*
 * Identity, the answer to LINK_HELLO:
 *     version u8, capabilities u8 (LINK_CAN_…), state words u16, block words u16,
 *     entries of a segment u16, schema u32, board u32 (config_identity_t), tick u32 in ps,
 *     baud rate u32, current full scale u32 in µA, bus full scale u32 in µV,
 *     build-id 20 bytes, ticket u32
 */
#define LINK_CAN_STREAM (0x01U) /* the board has a recorder */
#define LINK_CAN_STORE (0x02U)  /* the board has a store */
#define LINK_IDENTITY_BYTES (56U)

/*
 * Health, the answer to LINK_PING: hal_health_t, the losses of the link, why the chip has started
 * (hal_reset_t), and the ticket of the link
 *     load u8 in %, flags u8, adc_ic u16, late ticks u32,
 *     ticks that the stream has left out u32, reason u8, exception u8, ticket u32
 *
 * Flags: bit 0: the tick is lost; bits 1 and 2: the source in command (source_t); bits 3 to 5: why
 * the input is lost (input_lost_t; 0: it is there, or the board has none).
 */
#define LINK_HEALTH_TICK_LOST (0x01U)
#define LINK_HEALTH_SOURCE (1U) /* lowest bit */
#define LINK_HEALTH_SOURCE_MASK (3U)
#define LINK_HEALTH_INPUT (3U) /* lowest bit */
#define LINK_HEALTH_INPUT_MASK (7U)
#define LINK_HEALTH_BYTES (18U)

/*
 * A segment (LINK_SEGMENT): number u32, tick of its first frame u32, hash of the state before it
 * u32 (drive_words_hash), CRC of its configuration u32, entries of the segment before it u16,
 * follows u8 (1 if nothing is missing between the segment before it and this one, else 0).
 */
#define LINK_SEGMENT_BYTES (19U)

#endif
