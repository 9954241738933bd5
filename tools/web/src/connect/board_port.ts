// SPDX-License-Identifier: MIT
// A serial port and the line that the worker waits at: bytes go from one to the other.
import { SharedLine } from "../core/shared_line.ts";
import type { SerialPort } from "./web_serial.ts";

const BUFFER_BYTES = 1 << 16;
const FLUSH_MS = 500; // a port that takes nothing any more would hold its end up

async function opened(port: SerialPort, baudRate: number): Promise<void> {
    try {
        await port.open({ baudRate, bufferSize: BUFFER_BYTES });
    } catch (error) {
        const text = (error as Error).message.replace(/\.$/, "");
        throw new Error(
            `The port cannot be opened: ${text}. Another program may have it; on Linux the user has to be in the group dialout.`,
        );
    }
}

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
        await opened(port, baudRate);
        return new BoardPort(port);
    }

    write(bytes: Uint8Array): void {
        this.writer?.write(bytes).catch((error: Error) => this.lose(error));
    }

    // What was written before is sent. Rejects when the port does not close.
    async close(): Promise<void> {
        this.isClosing = true;
        this.line.close();
        await this.reader?.cancel().catch(() => undefined);
        await this.reading;
        await this.flush();
        try {
            await this.port.close();
        } catch (error) {
            const { name, message } = error as DOMException;
            if (name !== "InvalidStateError") { // a port that is gone is closed already
                throw new Error(`The port cannot be closed: ${message}`);
            }
        }
    }

    // Of a port that is gone it fails.
    private async flush(): Promise<void> {
        const { writer } = this;
        if (writer === undefined) {
            return;
        }
        let timer: ReturnType<typeof setTimeout> | undefined;
        const late = new Promise<never>((_, reject) => {
            timer = setTimeout(() => reject(new Error("the port takes nothing")), FLUSH_MS);
        });
        await Promise.race([writer.close(), late]).catch((error: Error) => writer.abort(error).catch(() => undefined));
        clearTimeout(timer);
        writer.releaseLock();
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
