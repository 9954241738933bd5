// SPDX-License-Identifier: MIT
// The configuration in force as a file, and files that become it: a block as it is, a motor file with the board's and the tuning's
// numbers.
import { useState } from "preact/hooks";
import type { Said } from "../core/protocol.ts";
import { FileDrop } from "../parts/file_drop.tsx";
import { download } from "../parts/format.ts";
import type { Board } from "./board.ts";
import { given } from "./given_file.ts";
import { keepMotor, nameOfFile } from "./own_motors.ts";
import type { Talk } from "./talk.ts";

const BLOCK = "board.nfb";

async function dump(talk: Talk): Promise<void> {
    const { bytes } = await talk.exchange(`dump ${BLOCK}`, "boardDump", null, ({ text }) => text);
    download(BLOCK, new Blob([bytes], { type: "application/octet-stream" }));
}

// One that the program takes is there for the boards that come, too.
async function adopt(talk: Talk, file: File): Promise<Said> {
    const name = nameOfFile(file.name);
    await talk.inTurn(file.name, "boardKeep", { name, file: await given(file) });
    keepMotor(name, await file.text());
    return talk.execute(`adopt ${name}`);
}

async function take(talk: Talk, file: File): Promise<Said> {
    if (/\.toml$/i.test(file.name)) {
        return adopt(talk, file);
    }
    const text = await talk.exchange(`load ${file.name}`, "boardLoad", await given(file), (said) => said);
    return { text, refused: false };
}

export function ConfigurationFiles({ board }: { board: Board }) {
    const [answer, setAnswer] = useState<Said>();
    const { talk } = board;
    const isDisabled = board.phase !== "following";
    const open = (file: File): void => {
        take(talk, file).then(setAnswer, ({ message }: Error) => setAnswer({ text: message, refused: true }));
    };
    return (
        <>
            <FileDrop
                text="Drop a block (.nfb) or a motor file (.toml) here. It becomes the configuration in force."
                label="Choose a block or a motor file" isDisabled={isDisabled} open={open}
            />
            <div class="buttons" role="group" aria-label="Files">
                <button
                    type="button" title="The configuration in force, for this board and others of its kind" disabled={isDisabled}
                    onClick={() => void dump(talk).catch(() => undefined)} // the dialogue has said why
                >
                    Download block
                </button>
            </div>
            {answer !== undefined && (
                <p class={answer.refused ? "problem" : "note"} role="status">{answer.text}</p>
            )}
        </>
    );
}
