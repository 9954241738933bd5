// SPDX-License-Identifier: MIT
// In the page, before its own scripts: a navigator.serial with one port, whose bytes go to and from the test (cable.mjs). It
// refuses what Chromium's refuses, with the same errors. With `fakeSerial` the test says how it is.
{
    const failure = (name, text) => new DOMException(text, name);
    const asText = (bytes) => btoa(String.fromCharCode(...bytes));
    const asBytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    // Of the other end of the line, where the rates are not the same.
    const heard = (bytes) => {
        const { baud, opened } = fakeSerial;
        return baud === undefined || baud === opened.baudRate ? bytes : bytes.map((byte) => byte ^ 0xa5);
    };

    // A stream comes into being when it is asked for, and is gone when it has ended or failed.
    class FakePort extends EventTarget {
        connected = true;
        #isOpen = false;
        #readable = null;
        #writable = null;
        #said; // the readable's controller

        async open({ baudRate, bufferSize = 255 }) {
            if (this.#isOpen) {
                throw failure("InvalidStateError", "The port is already open.");
            }
            if (!this.connected || fakeSerial.busy) {
                throw failure("NetworkError", "Failed to open serial port.");
            }
            await globalThis.serialOpen();
            this.#isOpen = true;
            fakeSerial.opened = { baudRate, bufferSize };
            fakeSerial.tried.push(baudRate);
        }

        get readable() {
            if (this.#isOpen) {
                this.#readable ??= new ReadableStream({
                    type: "bytes",
                    start: (controller) => (this.#said = controller),
                    cancel: () => (this.#readable = null),
                });
            }
            return this.#readable;
        }

        get writable() {
            const end = () => (this.#writable = null);
            if (this.#isOpen) {
                this.#writable ??= new WritableStream({ write: (bytes) => this.#write(bytes), close: end, abort: end });
            }
            return this.#writable;
        }

        // Rejects while somebody reads or writes.
        async close() {
            if (!this.#isOpen) {
                throw failure("InvalidStateError", "The port is already closed.");
            }
            await this.#readable?.cancel();
            await this.#writable?.abort();
            this.#isOpen = false;
            await globalThis.serialClose();
        }

        take(bytes) {
            if (this.readable !== null) {
                this.#said.enqueue(heard(bytes));
            }
        }

        // A byte has come damaged: this stream ends, and there is another one.
        disturb() {
            this.#said.error(failure("FramingError", "A framing error has been received."));
            this.#readable = null;
        }

        lose() {
            this.connected = this.#isOpen = false;
            this.#said.error(failure("NetworkError", "The device has been lost."));
            this.#readable = this.#writable = null;
            // An event of the port, which rises to navigator.serial.
            for (const listener of [this, navigator.serial]) {
                listener.dispatchEvent(Object.defineProperty(new Event("disconnect"), "target", { value: this }));
            }
        }

        async #write(bytes) {
            if (!this.connected) {
                throw failure("NetworkError", "The device has been lost.");
            }
            await globalThis.serialWrite(asText(heard(bytes)));
        }
    }

    class FakeSerial extends EventTarget {
        port = new FakePort();
        #allowed = [];

        async getPorts() {
            return this.#allowed;
        }

        async requestPort() {
            if (!navigator.userActivation.isActive) {
                throw failure("SecurityError", "Must be handling a user gesture to show a permission request.");
            }
            if (fakeSerial.cancelled) {
                throw failure("NotFoundError", "No port selected by the user.");
            }
            if (!this.port.connected) {
                this.port = new FakePort();
            }
            this.#allowed = [this.port];
            return this.port;
        }
    }

    const serial = new FakeSerial();
    globalThis.fakeSerial = {
        cancelled: false, // by the person who is to choose a port
        busy: false, // another program has the port
        baud: undefined, // of the board; undefined: any
        opened: undefined, // how the page has opened it
        tried: [], // rates, in their order
        take: (text) => serial.port.take(asBytes(text)),
        disturb: () => serial.port.disturb(),
        lose: () => serial.port.lose(),
    };
    Object.defineProperty(navigator, "serial", { value: serial });
}
