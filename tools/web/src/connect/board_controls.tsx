// SPDX-License-Identifier: MIT
// What a person asks of a running board: requests, a command, a recording.
import type { PlayMode } from "../core/protocol.ts";
import { CommandChoice } from "../parts/command_choice.tsx";
import { download } from "../parts/format.ts";
import { Requests } from "../parts/requests.tsx";
import type { TabProps } from "../tab.ts";
import type { Board } from "./board.ts";
import type { Recording } from "./talk.ts";

const POSITION_MAX_DEG = 3600; // of the slider
const NOTES: Record<PlayMode, string> = {
    speed: "The choice sends nothing; a value does.",
    position: "From where the rotor was. The choice sends nothing; a value does.",
    torque: "Of the motor. The choice sends nothing; a value does.",
};
const LOG = "field.log";

function Command({ board }: { board: Board }) {
    const { steering } = board.talk;
    return (
        <CommandChoice
            mode={steering.mode} value={steering.value}
            largest={{ speed: board.head?.speed_max_rpm ?? 0, position: POSITION_MAX_DEG, torque: board.head?.torque_max_nm ?? 0 }}
            note={NOTES[steering.mode]}
            onMode={(mode) => steering.choose(mode)} onValue={(value) => steering.go(value)}
            onHold={(isHeld) => steering.hold(isHeld)}
        />
    );
}

function Recorded({ board, recording, props }: { board: Board; recording: Recording; props: TabProps }) {
    const replay = async (): Promise<void> => {
        try {
            await props.client.ask("replayOpen", { name: LOG, bytes: new TextEncoder().encode(recording.log) });
            props.show("replay");
        } catch (error) {
            board.talk.log("refusal", (error as Error).message);
        }
    };
    return (
        <>
            <button type="button" onClick={() => download(LOG, new Blob([recording.log], { type: "text/plain" }))}>
                {`Download ${LOG}`}
            </button>
            <button type="button" onClick={() => void replay()}>Open in Replay</button>
        </>
    );
}

export function RecordButtons({ board, props }: { board: Board; props: TabProps }) {
    const { isRecording, recording } = board.talk;
    return (
        <div class="buttons" role="group" aria-label="Recording">
            <button
                type="button" title="The ticks that are kept, up to the last fault"
                disabled={isRecording || board.phase !== "following"} onClick={() => void board.talk.record()}
            >
                {isRecording ? "Recording…" : "Record"}
            </button>
            {recording !== undefined && <Recorded board={board} recording={recording} props={props} />}
        </div>
    );
}

export function BoardControls({ board }: { board: Board }) {
    return (
        <section class="controls" aria-label="Controls">
            <Requests stopTitle="Stops at once, also with Escape" ask={(what) => void board.talk.execute(what)} />
            <Command board={board} />
        </section>
    );
}
