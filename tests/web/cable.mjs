// SPDX-License-Identifier: MIT
// The cable between the page's navigator.serial (fake_serial.mjs) and a device of the test. A device has open(take), write(bytes)
// and close(); `take` gets what it says.
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

export const FAKE_SERIAL = { path: join(dirname(fileURLToPath(import.meta.url)), "fake_serial.mjs") };

export class Cable {
    #page;
    #device;
    #waiting = []; // what the page has not got yet
    #passing = Promise.resolve();
    #open = false;

    // The page has begun with FAKE_SERIAL.
    static async of(page, device) {
        const cable = new Cable();
        cable.#page = page;
        cable.#device = device;
        await page.exposeBinding("serialOpen", () => cable.#begin());
        await page.exposeBinding("serialWrite", (_, text) => cable.#device.write(Buffer.from(text, "base64")));
        await page.exposeBinding("serialClose", () => cable.close());
        return cable;
    }

    // It is pulled out while the page uses it.
    async pull() {
        await this.close();
        await this.#page.evaluate(() => globalThis.fakeSerial.lose());
    }

    // The other end is at another device from now on.
    async plug(device) {
        await this.pull();
        this.#device = device;
    }

    // Before the page goes away.
    async close() {
        if (this.#open) {
            this.#open = false;
            this.#device.close();
        }
        this.#waiting = [];
        await this.#passing;
    }

    #begin() {
        this.#open = true;
        this.#device.open((bytes) => this.#take(bytes));
    }

    #take(bytes) {
        this.#waiting.push(bytes);
        if (this.#waiting.length === 1) {
            this.#passing = this.#passing.then(() => this.#pass());
        }
    }

    // All that has come meanwhile goes in one piece.
    async #pass() {
        const text = Buffer.concat(this.#waiting.splice(0)).toString("base64");
        if (this.#open) {
            await this.#page.evaluate((bytes) => globalThis.fakeSerial.take(bytes), text);
        }
    }
}
