// SPDX-License-Identifier: MIT
// One after the other. What still waits can be dropped.

// Of what was dropped before its turn.
export class Dropped extends Error {}

export class Turns {
    private last: Promise<unknown> = Promise.resolve();
    private drops = 0;
    private reason = ""; // of the newest drop

    // Rejects when it is dropped; `name` says what was.
    take<Value>(name: string, act: () => Promise<Value>): Promise<Value> {
        const { drops } = this;
        const mine = this.last.then(() => {
            if (drops !== this.drops) {
                throw new Dropped(`${name}: not done, ${this.reason}`);
            }
            return act();
        });
        this.last = mine.catch(() => undefined);
        return mine;
    }

    drop(reason: string): void {
        this.drops++;
        this.reason = reason;
    }
}
