// SPDX-License-Identifier: MIT
// The parts of the bench; each is a row.
import { ConnectTab } from "./connect/connect_tab.tsx";
import { PlayTab } from "./play/play_tab.tsx";
import { ReplayTab } from "./replay/replay_tab.tsx";
import { RunTab } from "./run/run_tab.tsx";
import { StepTab } from "./step/step_tab.tsx";
import type { Tab } from "./tab.ts";

// The id is the one of the address.
export const TABS: Tab[] = [
    { id: "simulate", title: "Simulate", view: RunTab },
    { id: "play", title: "Play", view: PlayTab },
    { id: "step", title: "Step", view: StepTab },
    { id: "replay", title: "Replay", view: ReplayTab },
    { id: "connect", title: "Connect", view: ConnectTab },
];
