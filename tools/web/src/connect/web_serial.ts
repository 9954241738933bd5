// SPDX-License-Identifier: MIT
// The members of Web Serial that are used: TypeScript's library has none of them.

export interface SerialPort {
    readonly readable: ReadableStream<Uint8Array> | null; // null: the port is gone, or not open
    readonly writable: WritableStream<Uint8Array> | null;
    open(options: { baudRate: number; bufferSize: number }): Promise<void>;
    close(): Promise<void>;
}

export interface Serial {
    // Lets a person choose; rejects with NotFoundError when none is chosen.
    requestPort(): Promise<SerialPort>;
}

export function serialOf(browser: Navigator & { serial?: Serial }): Serial | undefined {
    return browser.serial;
}
