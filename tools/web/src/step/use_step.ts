// SPDX-License-Identifier: MIT
// The stepper's session as the page sees it: what is open, the present tick, and what was said.
import { useEffect, useRef, useState } from "preact/hooks";
import { type Client, type Pending, Stopped } from "../core/client.ts";
import type { StepHead, StepSource, StepView } from "../core/protocol.ts";
import { preparedChoice, selectionOfLink } from "../run/selection_link.ts";

export interface Said {
    line: string;
    text: string;
    refused: boolean;
}

export interface Stepper {
    source: StepSource;
    head: StepHead | undefined;
    view: StepView | undefined;
    said: Said[];
    runningAt: number | undefined; // the tick that a long command is at
    problem: string;
    open(source: StepSource): Promise<void>;
    execute(line: string): Promise<void>; // and says what came of it
    walk(line: string): Promise<void>; // the same, but says refusals alone
    stop(): void;
}

const SAID_MAX = 200;
const STOPPED = "stopped: interrupted"; // as the program says it

async function opened(client: Client, source: StepSource): Promise<StepHead> {
    const choice = source === "scenario" ? await preparedChoice(client, (await selectionOfLink()).selection) : null;
    return client.ask("stepOpen", { source, choice });
}

interface Execution {
    runningAt: number | undefined;
    // One after the other: while one is under way, another is not taken.
    execute(line: string, quietly: boolean): Promise<void>;
    stop(): void;
}

function useExecution(client: Client, say: (said: Said) => void, look: () => Promise<void>): Execution {
    const [runningAt, setRunningAt] = useState<number>();
    const pending = useRef<Pending<{ text: string; refused: boolean }> | undefined>(undefined);
    const stop = (): void => pending.current?.stop();
    const execute = async (line: string, quietly: boolean): Promise<void> => {
        if (pending.current !== undefined) {
            return;
        }
        pending.current = client.begin("stepExecute", { line }, setRunningAt);
        try {
            const answer = await pending.current.done;
            if (!quietly || answer.refused) {
                say({ line, ...answer });
            }
        } catch (error) {
            say({ line, text: error instanceof Stopped ? STOPPED : (error as Error).message, refused: true });
        }
        setRunningAt(undefined);
        await look();
        pending.current = undefined;
    };
    useEffect(() => stop, []);
    return { runningAt, execute, stop };
}

export function useStep(client: Client, first: StepSource): Stepper {
    const [source, setSource] = useState(first);
    const [head, setHead] = useState<StepHead>();
    const [view, setView] = useState<StepView>();
    const [said, setSaid] = useState<Said[]>([]);
    const [problem, setProblem] = useState("");
    const failed = (error: Error): void => setProblem(error.message);
    const look = (): Promise<void> => client.ask("stepLook", null).then(setView, failed);
    const say = (one: Said): void => setSaid((all) => [...all, one].slice(-SAID_MAX));
    const { runningAt, execute, stop } = useExecution(client, say, look);

    const open = async (next: StepSource): Promise<void> => {
        setSource(next);
        setProblem("");
        setSaid([]);
        setView(undefined);
        try {
            setHead(await opened(client, next));
            await look();
        } catch (error) {
            failed(error as Error);
        }
    };
    useEffect(() => void open(first), []);
    return {
        source, head, view, said, runningAt, problem, open, stop,
        execute: (line) => execute(line, false),
        walk: (line) => execute(line, true),
    };
}
