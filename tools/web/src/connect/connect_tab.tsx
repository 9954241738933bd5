// SPDX-License-Identifier: MIT
// Connect: a running board at a serial port, as `motorsim live` shows it.
import { useState } from "preact/hooks";
import { ScopeScene, SpanChoice } from "../parts/scope_scene.tsx";
import type { TabProps } from "../tab.ts";
import { Alarms } from "./alarms.tsx";
import type { Board } from "./board.ts";
import { BoardControls, RecordButtons } from "./board_controls.tsx";
import { BoardNow } from "./board_now.tsx";
import { Connection } from "./connection.tsx";
import { DialogueView } from "./dialogue_view.tsx";
import { MeasureMotor } from "./measure_motor.tsx";
import { Parameters } from "./parameters.tsx";
import { WhereAvailable } from "./unavailable.tsx";
import { useBoard } from "./use_board.ts";

function Side({ props, board }: { props: TabProps; board: Board }) {
    return (
        <div class="side scroll" tabIndex={0} role="group" aria-label="The board">
            <Connection board={board} props={props} />
            <Alarms board={board} />
            {board.phase === "following" && <BoardControls board={board} />}
            {board.head !== undefined && (
                <>
                    <RecordButtons board={board} props={props} />
                    <DialogueView board={board} />
                </>
            )}
        </div>
    );
}

const PANELS = ["Signals", "Parameters", "Measure the motor"] as const;
type Panel = (typeof PANELS)[number];

interface ToolbarProps {
    board: Board;
    open: Panel | undefined;
    setOpen(open: Panel | undefined): void;
}

function Toolbar({ board, open, setOpen }: ToolbarProps) {
    const { panels, span } = board.scopes;
    return (
        <div class="buttons toolbar">
            <SpanChoice span={span} setSpan={(next) => void board.setScope(panels, next)} />
            {PANELS.map((name) => (
                <button
                    type="button" key={name} aria-pressed={open === name}
                    onClick={() => setOpen(open === name ? undefined : name)}
                >
                    {name}
                </button>
            ))}
        </div>
    );
}

function Beside({ open, board, props }: { open: Panel | undefined; board: Board; props: TabProps }) {
    switch (open) {
        case "Parameters":
            return <Parameters board={board} />;
        case "Measure the motor":
            return <MeasureMotor board={board} schema={props.schema} />;
        default:
            return null;
    }
}

function Main({ board, props }: { board: Board; props: TabProps }) {
    const [open, setOpen] = useState<Panel>();
    const { track, panels, span } = board.scopes;
    if (board.head === undefined) {
        return (
            <div class="run-main">
                <p class="note">
                    A board that runs the firmware of this bench shows every signal of each control tick here. The page computes each
                    value from the board's measurements, and checks it against a hash that the board sends.
                </p>
            </div>
        );
    }
    return (
        <div class="run-main">
            <Toolbar board={board} open={open} setOpen={setOpen} />
            <ScopeScene
                label="Scopes and state" signals={board.signals} track={track} panels={panels} span={span}
                choosing={open === "Signals"} setPanels={(next) => void board.setScope(next, span)}
                beside={<Beside open={open} board={board} props={props} />}
            >
                <BoardNow board={board} />
            </ScopeScene>
        </div>
    );
}

function Bench({ props }: { props: TabProps }) {
    const board = useBoard();
    return (
        <div class="run connect">
            <Side props={props} board={board} />
            <Main board={board} props={props} />
        </div>
    );
}

export function ConnectTab(props: TabProps) {
    return <WhereAvailable><Bench props={props} /></WhereAvailable>;
}
