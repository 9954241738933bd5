// SPDX-License-Identifier: MIT
// A file that a person has chosen or dropped, for the simulator.
import type { GivenFile } from "../core/protocol.ts";

export async function given(file: File): Promise<GivenFile> {
    return { name: file.name, bytes: new Uint8Array(await file.arrayBuffer()) };
}
