// SPDX-License-Identifier: MIT
// A motor file of the person, for the boards that are connected next: the name of a board's motor leads to it.
import { useState } from "preact/hooks";
import type { Client } from "../core/client.ts";
import type { Said } from "../core/protocol.ts";
import { FileDrop } from "../parts/file_drop.tsx";
import { keepMotor, nameOfFile } from "./own_motors.ts";

async function kept(client: Client, file: File): Promise<Said> {
    const text = await file.text();
    const [problem] = await client.ask("check", { kind: "motor", file: file.name, text, choice: null });
    if (problem !== undefined) {
        return { text: problem.text, refused: true };
    }
    keepMotor(nameOfFile(file.name), text);
    return { text: `${file.name}: known until the page is loaded anew`, refused: false };
}

export function OwnMotorChoice({ client, changed }: { client: Client; changed(): void }) {
    const [answer, setAnswer] = useState<Said>();
    const open = async (file: File): Promise<void> => {
        setAnswer(await kept(client, file));
        changed();
    };
    return (
        <>
            <FileDrop
                text="A motor that is no shipped one: drop its file here." label="Choose a motor file" open={(file) => void open(file)}
            />
            {answer !== undefined && <p class={answer.refused ? "problem" : "note"} role="status">{answer.text}</p>}
        </>
    );
}
