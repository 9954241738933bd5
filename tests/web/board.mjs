// SPDX-License-Identifier: MIT
// Boards that a page connects to: programs with a pseudo-terminal, each a device for a Cable.
// The environment says where they are: NF_MOTORSIM; NF_PYTHON, NF_IMAGE, NF_IMAGE_BOARD, NF_CLOCK and NF_BIL_MOTOR.
import { spawn } from "node:child_process";
import { once } from "node:events";
import { constants, openSync } from "node:fs";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { ReadStream } from "node:tty";
import { ROOT, setting } from "./bench.mjs";

// Seconds of the board in a second: a machine with much else to do keeps up with them.
export const SIMULATED_PACE = 0.25;
export const EMULATED_PACE = 0.05;

class Board {
    #program;
    #path; // of its terminal
    #stream;

    // The program says its terminal in its first line.
    static async of(command, args) {
        const board = new Board();
        board.#program = spawn(command, args, { cwd: ROOT, stdio: ["pipe", "pipe", "inherit"] });
        for await (const line of createInterface({ input: board.#program.stdout })) {
            board.#path = /\/dev\/\S+\d/.exec(line)[0];
            return board;
        }
        throw new Error(`${command} has ended before it said its terminal`);
    }

    open(take) {
        this.#stream = new ReadStream(openSync(this.#path, constants.O_RDWR | constants.O_NOCTTY));
        this.#stream.on("data", take);
    }

    write(bytes) {
        this.#stream.write(bytes);
    }

    close() {
        this.#stream.destroy();
    }

    // To the program itself.
    tell(line) {
        this.#program.stdin.write(`${line}\n`);
    }

    // It stands still, and so says nothing.
    freeze() {
        this.#program.kill("SIGSTOP");
    }

    thaw() {
        this.#program.kill("SIGCONT");
    }

    // Its flash is written by then.
    async switchOff() {
        const ended = once(this.#program, "exit");
        this.#program.kill("SIGTERM");
        await ended;
    }

    end() {
        this.#program.kill("SIGKILL");
    }
}

function simulated(scenario, options = []) {
    return Board.of(setting("NF_MOTORSIM"), ["live", "--simulate", scenario, "--pace", String(SIMULATED_PACE), ...options]);
}

// Its script commands it until somebody else does.
export function simulatedBoard() {
    return simulated("s1_robust");
}

// Of a scenario in which nobody asks for anything: its image has the example motor of the board, the machine is another one.
// `flash` is the file of what it keeps while it is switched off.
export function boardOutOfTheBox(machine, flash) {
    const settings = [
        "scenario.load=[]", "scenario.command=[]", "scenario.request=[{time_s=0, run=false}]", "scenario.duration_s=200",
        ...Object.entries(machine).map(([key, value]) => `plant.${key}=${value}`),
    ];
    return simulated("any", [
        "--motor", "outrunner_24v", "--board", "b_g431b_esc1", "--flash", flash, ...settings.flatMap((each) => ["--set", each]),
    ]);
}

// The image that is flashed. It obeys the lines of port.py.
export function emulatedBoard() {
    const files = ["NF_IMAGE", "NF_IMAGE_BOARD", "NF_CLOCK", "NF_BIL_MOTOR"].map(setting);
    return Board.of(setting("NF_PYTHON"), [join(ROOT, "tests/bil/port.py"), ...files]);
}
