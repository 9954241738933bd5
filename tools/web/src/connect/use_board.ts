// SPDX-License-Identifier: MIT
// The one board of the page. It is above the parts of the bench: whoever comes back to Connect finds it as it is.
import { useEffect, useState } from "preact/hooks";
import { Board } from "./board.ts";

const board = new Board();

export function useBoard(): Board {
    const [, show] = useState(0);
    useEffect(() => board.changed.add(() => show((count) => count + 1)), []);
    return board;
}
