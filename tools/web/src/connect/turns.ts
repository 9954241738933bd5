// SPDX-License-Identifier: MIT
// One after the other. What still waits can be dropped.

export class Turns {
    private last: Promise<unknown> = Promise.resolve();
    private drops = 0;

    // Rejects when it is dropped; `name` says what was.
    take<Value>(name: string, act: () => Promise<Value>): Promise<Value> {
        const { drops } = this;
        const mine = this.last.then(() => {
            if (drops !== this.drops) {
                throw new Error(`${name}: not done, a stop came before its turn`);
            }
            return act();
        });
        this.last = mine.catch(() => undefined);
        return mine;
    }

    drop(): void {
        this.drops++;
    }
}
