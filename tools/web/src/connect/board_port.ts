// SPDX-License-Identifier: MIT
// A serial port and the line that the worker waits at: bytes go from one to the other.
import { SharedLine } from "../core/shared_line.ts";
import type { SerialPort } from "./web_serial.ts";

const BUFFER_BYTES = 1 << 16;

export class BoardPort {
    readonly line = new SharedLine();
    problem = ""; // why the port has gone; empty while it is there
    private reader: ReadableStreamDefaultReader<Uint8Array> | undefined;
    private readonly writer: WritableStreamDefaultWriter<Uint8Array> | undefined;
    private readonly reading: Promise<void>;
    private isClosing = false;

    private constructor(private readonly port: SerialPort) {
        this.writer = port.writable?.getWriter();
        this.writer?.closed.catch(() => undefined); // a write that fails says so
        this.reading = this.read();
    }

    static async open(port: SerialPort, baudRate: number): Promise<BoardPort> {
        await port.open({ baudRate, bufferSize: BUFFER_BYTES });
        return new BoardPort(port);
    }

    write(bytes: Uint8Array): void {
        this.writer?.write(bytes).catch((error: Error) => this.lose(error));
    }

    // What was written before is sent.
    async close(): Promise<void> {
        this.isClosing = true;
        this.line.close();
        await this.reader?.cancel().catch(() => undefined);
        await this.reading;
        await this.writer?.close().catch(() => undefined); // of a port that is gone it fails
        await this.port.close().catch(() => undefined);
    }

    // After a byte that was damaged or came too fast the port has another stream; after it is unplugged none.
    private async read(): Promise<void> {
        let why = new Error("it has ended");
        while (this.port.readable !== null && !this.isClosing) {
            this.reader = this.port.readable.getReader();
            try {
                await this.pump(this.reader);
            } catch (error) {
                why = error as Error;
            }
            this.reader.releaseLock();
        }
        this.lose(why);
    }

    private async pump(reader: ReadableStreamDefaultReader<Uint8Array>): Promise<void> {
        for (let got = await reader.read(); !got.done; got = await reader.read()) {
            this.line.put(got.value);
        }
    }

    private lose(error: Error): void {
        if (!this.isClosing && this.problem === "") {
            this.problem = `the port is gone: ${error.message}`;
        }
        this.line.close();
    }
}
