// SPDX-License-Identifier: MIT
// A port with a simulator of its own that follows what is at it, so that it never holds up the other parts of the bench.
import { Client } from "../core/client.ts";
import type { RequestName, Requests } from "../core/protocol.ts";
import { BoardPort } from "./board_port.ts";
import type { SerialPort } from "./web_serial.ts";

export class BoardLink {
    private readonly client: Client;

    private constructor(private readonly port: BoardPort) {
        this.client = new Client((bytes) => port.write(bytes));
    }

    static async open(port: SerialPort, baud: number): Promise<BoardLink> {
        return new BoardLink(await BoardPort.open(port, baud));
    }

    get memory(): SharedArrayBuffer {
        return this.port.line.memory;
    }

    // How often a stop was asked for.
    get stops(): number {
        return this.port.line.stops;
    }

    // Why the port has gone; empty while it is there.
    get problem(): string {
        return this.port.problem;
    }

    ask<Name extends RequestName>(name: Name, given: Requests[Name]["given"]): Promise<Requests[Name]["back"]> {
        return this.client.ask(name, given);
    }

    // The simulator tells the board, also while it waits for something else, and says what came of it.
    askStop(): void {
        this.port.line.askStop();
    }

    // Whatever is under way ends with an error.
    cut(): void {
        this.client.end();
    }

    // Rejects when the port does not close.
    async close(): Promise<void> {
        this.client.end();
        await this.port.close();
    }
}
