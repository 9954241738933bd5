// SPDX-License-Identifier: MIT
// Replay: a log of the field with a recording in it. What it is, the curves before the fault, and the way to the stepper.
import { useEffect, useMemo, useState } from "preact/hooks";
import type { Client } from "../core/client.ts";
import type { Curves as Recorded, ReplayHead } from "../core/protocol.ts";
import { FIRST_PANELS } from "../parts/board_panels.ts";
import { FileDrop } from "../parts/file_drop.tsx";
import { Curves } from "../run/curves.tsx";
import type { TabProps } from "../tab.ts";

const SAMPLE =
    `build/host/motorsim run s1_robust --record field.log --set 'scenario.fault=[{time_s=0.3, what="phase_a_open"}]'`;

interface Opened {
    head: ReplayHead;
    curves: Recorded;
}

interface Replay {
    opened: Opened | undefined;
    panels: string[][];
    problem: string;
    open(file: File): Promise<void>;
    setPanels(panels: string[][]): void;
}

function useReplay(client: Client): Replay {
    const [opened, setOpened] = useState<Opened>();
    const [panels, setPanels] = useState(FIRST_PANELS);
    const [problem, setProblem] = useState("");
    const show = async (head: ReplayHead, shown: string[][]): Promise<void> => {
        const signals = [...new Set(shown.flat())];
        setOpened({ head, curves: await client.ask("replayColumns", { signals }) });
    };
    const failed = (error: Error): void => setProblem(error.message);
    const open = async (file: File): Promise<void> => {
        setProblem("");
        setOpened(undefined);
        try {
            const bytes = new Uint8Array(await file.arrayBuffer());
            await show(await client.ask("replayOpen", { name: file.name, bytes }), panels);
        } catch (error) {
            failed(error as Error);
        }
    };
    // One that is open stays so while another tab is shown.
    useEffect(() => {
        client.ask("replayHead", null).then((head) => head === null ? undefined : show(head, panels)).catch(failed);
    }, []);
    return {
        opened, panels, problem, open,
        setPanels: (next) => {
            setPanels(next);
            if (opened !== undefined) {
                show(opened.head, next).catch(failed);
            }
        },
    };
}

function Fault({ head }: { head: ReplayHead }) {
    return (
        <>
            {head.faults.map((fault) => (
                <div class="fault" role="note" key={fault.time_s}>
                    <strong>{fault.measure}</strong>
                    <p>{fault.advice}</p>
                </div>
            ))}
        </>
    );
}

function Introduction() {
    return (
        <section class="explained" aria-label="Where a recording comes from">
            <h2>No recording is open</h2>
            <p>
                Drop a file with a recording at the place for it, or choose one there. The curves before the fault are shown here then,
                and the way to the stepper at the tick of the fault.
            </p>
            <p>A recording comes from</p>
            <ul>
                <li>a board at this page: Connect, then Record and Open in Replay;</li>
                <li>a board at a terminal: the command dump, whatever the terminal writes into its log;</li>
                <li>
                    no board at all. This makes a sample, in which a phase opens at 0.3 s:
                    <pre>{SAMPLE}</pre>
                </li>
            </ul>
        </section>
    );
}

export function ReplayTab({ client, show }: TabProps) {
    const replay = useReplay(client);
    const { opened, panels, problem } = replay;
    const drawn = useMemo(
        () => opened && { ...opened.curves, signals: opened.head.signals, faults: opened.head.faults },
        [opened],
    );
    return (
        <div class="run">
            <div class="side scroll" tabIndex={0} role="group" aria-label="The recording">
                <FileDrop
                    text="Drop a log of the serial line here, with a recording of the flight recorder in it." label="Or choose a file"
                    open={(file) => void replay.open(file)}
                />
                {problem !== "" && <p class="problem" role="alert">{problem}</p>}
                {opened !== undefined && (
                    <section class="summary" aria-label="Summary">
                        <pre>{opened.head.summary}</pre>
                        <Fault head={opened.head} />
                        <button type="button" class="main" onClick={() => show("step", "recording")}>
                            {`Step from tick ${opened.head.step_tick}`}
                        </button>
                    </section>
                )}
            </div>
            <div class="run-main">
                {drawn === undefined
                    ? <Introduction />
                    : <Curves run={drawn} panels={panels} onPanels={replay.setPanels} />}
            </div>
        </div>
    );
}
