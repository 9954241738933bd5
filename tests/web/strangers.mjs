// SPDX-License-Identifier: MIT
// Devices for a Cable that are no board of this firmware.

// `answer` makes of what was written what it says.
class Stranger {
    #answer;
    #take;

    constructor(answer) {
        this.#answer = answer;
    }

    open(take) {
        this.#take = take;
    }

    write(bytes) {
        const answer = this.#answer(bytes);
        if (answer.length > 0) {
            this.#take(answer);
        }
    }

    close() {}

    end() {}
}

// It has another protocol.
export function printer() {
    return new Stranger(() => Buffer.from("start\r\nError: unknown command\r\n"));
}

// The link as firmware/app/link_messages.h has it.
const HELLO = 1;
const ANSWER = 0x80;
const IDENTITY_BYTES = 52;
const CRC_POLYNOMIAL = 0xedb88320;

function crc32(bytes) {
    let crc = 0xffffffff;
    for (const byte of bytes) {
        crc ^= byte;
        for (let bit = 0; bit < 8; bit++) {
            crc = crc & 1 ? (crc >>> 1) ^ CRC_POLYNOMIAL : crc >>> 1;
        }
    }
    return ~crc >>> 0;
}

// Of a message that is shorter than the 254 bytes from which on COBS has a code without a zero.
function framed(message) {
    const crc = Buffer.alloc(4);
    crc.writeUInt32LE(crc32(message));
    const parts = Buffer.concat([message, crc]).toString("latin1").split("\0");
    const code = parts.map((part) => String.fromCharCode(part.length + 1) + part).join("");
    return Buffer.from(`\0${code}\0`, "latin1");
}

// A board whose firmware has another version of the link.
export function otherFirmware(version) {
    return new Stranger((bytes) => {
        const [, type, tag] = bytes[0] === 0 ? bytes.subarray(1) : bytes; // neither is zero, so COBS leaves them
        const identity = Buffer.alloc(IDENTITY_BYTES);
        identity[0] = version;
        return type === HELLO ? framed(Buffer.concat([Buffer.from([HELLO + ANSWER, tag]), identity])) : Buffer.alloc(0);
    });
}
