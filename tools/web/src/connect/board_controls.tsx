// SPDX-License-Identifier: MIT
// What a person asks of a running board: requests, a command, a recording.
import type { PlayMode } from "../core/protocol.ts";
import { CommandChoice } from "../parts/command_choice.tsx";
import { download } from "../parts/format.ts";
import { Requests } from "../parts/requests.tsx";
import type { TabProps } from "../tabs.ts";
import type { Board } from "./board.ts";
import type { Recording } from "./talk.ts";

const POSITION_MAX_DEG = 3600; // of the slider
const DEG_PER_RAD = 180 / Math.PI;
const LOG = "field.log";

// Another mode changes nothing yet: a position is that of the shaft, and the motor would turn to it.
function begin(board: Board, mode: PlayMode): void {
    const at = Math.round((board.block?.values["position_estimated_rad"] ?? 0) * DEG_PER_RAD);
    board.talk.steering.begin({ mode, value: mode === "position" ? at : 0 });
}

function Command({ board }: { board: Board }) {
    const { steering } = board.talk;
    return (
        <CommandChoice
            mode={steering.shown.mode} value={steering.shown.value}
            largest={{ speed: board.head?.speed_max_rpm ?? 0, position: POSITION_MAX_DEG }}
            note="The choice sends nothing; a value does."
            onMode={(mode) => begin(board, mode)} onValue={(value) => steering.go(value)}
        />
    );
}

function Recorded({ recording, props }: { recording: Recording; props: TabProps }) {
    const replay = async (): Promise<void> => {
        const bytes = new TextEncoder().encode(recording.log);
        await props.client.ask("replayOpen", { name: LOG, bytes });
        props.show("replay");
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
                {isRecording ? "Records…" : "Record"}
            </button>
            {recording !== undefined && <Recorded recording={recording} props={props} />}
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
