// SPDX-License-Identifier: MIT
// The drive of the board that is followed measures its motor; motor files and blocks come and go.
import { isStoppedSince } from "./open_line.ts";
import type { GivenFile, Measured, Plate, Requests } from "./protocol.ts";
import type { Core } from "./wasm.ts";

type Given<Name extends keyof Requests> = Requests[Name]["given"];

const BLOCK = "board.nfb";

export function boardPlate(core: Core, { name, bytes }: GivenFile): Plate {
    return core.callWithFile("board.plate", name, bytes);
}

export function boardIdentify(core: Core, { file: { name, bytes }, stops }: Given<"boardIdentify">): string {
    if (isStoppedSince(stops)) {
        throw new Error("identify: not done, a stop came before its turn");
    }
    return core.callWithFile("board.identify", name, bytes);
}

export function boardMeasured(core: Core): Measured {
    return core.call("board.measured", {});
}

// One that the program does not take is refused before it stands in another one's place.
export function boardKeep(core: Core, { name, file }: Given<"boardKeep">): null {
    core.callWithFile("board.motor", file.name, file.bytes);
    core.addMotors({ [name]: new TextDecoder().decode(file.bytes) });
    return null;
}

export function boardDump(core: Core): Requests["boardDump"]["back"] {
    const text = core.call<string>("board.dump", { file: BLOCK });
    return { text, bytes: core.takeBytes(BLOCK) };
}

export function boardLoad(core: Core, { name, bytes }: GivenFile): string {
    return core.callWithFile("board.load", name, bytes);
}
