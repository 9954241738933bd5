// SPDX-License-Identifier: MIT
// The machine of the tab Play: made of the choice in the link, kept while another tab is open.
import { useEffect, useRef, useState } from "preact/hooks";
import type { Client } from "../core/client.ts";
import type { Knobs, PlayAct, PlayBlock, PlayHead, ScopeChoice } from "../core/protocol.ts";
import type { Selection } from "../run/bench_state.ts";
import { preparedChoice } from "../run/selection_link.ts";
import { type Pace, Player } from "./player.ts";

const REFRESH_MS = 100; // of what a person reads

export interface Play {
    head: PlayHead | undefined;
    knobs: Knobs | undefined;
    player: Player | undefined;
    block: PlayBlock | undefined; // now and then, for reading
    pace: Pace;
    running: boolean;
    problem: string;
    begin(selection: Selection): Promise<void>; // anew
    setRunning(running: boolean): void;
    act(act: PlayAct): void;
    setScope(scope: ScopeChoice): void;
}

interface Machine {
    head: PlayHead;
    player: Player;
}

// Also redraws the readers now and then.
function useRefresh(player: Player | undefined): void {
    const [, refresh] = useState(0);
    useEffect(() => {
        const timer = setInterval(() => refresh((count) => count + 1), REFRESH_MS);
        return () => {
            clearInterval(timer);
            player?.pause();
        };
    }, [player]);
}

export function usePlay(client: Client, scope: ScopeChoice): Play {
    const [machine, setMachine] = useState<Machine>();
    const [knobs, setKnobs] = useState<Knobs>();
    const [running, setRunning] = useState(false);
    const [problem, setProblem] = useState("");
    const newest = useRef(scope);
    newest.current = scope;
    const failed = (error: Error): void => setProblem(error.message);
    useRefresh(machine?.player);

    const use = (head: PlayHead): Player => {
        const player = new Player(client, head.period_s, newest.current, failed);
        setMachine({ head, player });
        setKnobs(head.knobs);
        return player;
    };
    const go = (player: Player, on: boolean): void => {
        on ? player.run() : player.pause();
        setRunning(on);
    };
    const begin = async (selection: Selection): Promise<void> => {
        machine?.player.pause();
        setProblem("");
        try {
            const choice = await preparedChoice(client, selection);
            go(use(await client.ask("playStart", { choice, scope: newest.current })), true);
        } catch (error) {
            failed(error as Error);
        }
    };
    // One that is there already stands still until a person lets time go by.
    useEffect(() => {
        client.ask("playHead", null).then(async (head) => {
            if (head !== null) {
                await use(head).setScope(newest.current);
            }
        }).catch(failed);
    }, []);

    return {
        head: machine?.head, knobs, player: machine?.player, block: machine?.player.block, running, problem, begin,
        pace: machine?.player.pace ?? { ratio: 0, frames: 0, dropped: 0 },
        setRunning: (on) => machine && go(machine.player, on),
        act: (act) => {
            setProblem("");
            machine?.player.act(act).then(setKnobs).catch(failed);
        },
        setScope: (next) => void machine?.player.setScope(next).catch(failed),
    };
}
