// SPDX-License-Identifier: MIT
// A stop that a person has asked for, until the board has answered. A motor may turn as long as it has not.
import type { Said } from "../core/protocol.ts";

export class Stopping {
    isPending = false;
    problem = ""; // why the newest stop is not confirmed
    private waiting: ((isConfirmed: boolean) => void)[] = [];

    // Whether the board confirms it.
    ask(): Promise<boolean> {
        this.isPending = true;
        this.problem = "";
        return new Promise((resolve) => this.waiting.push(resolve));
    }

    take({ text, refused }: Said): void {
        this.settle(refused ? text : "");
    }

    // No answer can come any more.
    lose(reason: string): void {
        if (this.isPending) {
            this.settle(reason);
        }
    }

    // With another board.
    begin(): void {
        this.settle("");
    }

    private settle(problem: string): void {
        this.isPending = false;
        this.problem = problem;
        this.waiting.splice(0).forEach((resolve) => resolve(problem === ""));
    }
}
