// SPDX-License-Identifier: MIT
// The machine of the tab Play: made of the choice in the link, kept while another tab is open.
import { useEffect, useRef, useState } from "preact/hooks";
import type { Client } from "../core/client.ts";
import type { Knobs, PlayAct, PlayBlock, PlayHead, ScopeChoice } from "../core/protocol.ts";
import { useRefresh } from "../parts/use_refresh.ts";
import type { Selection } from "../run/bench_state.ts";
import { preparedChoice } from "../run/selection_link.ts";
import { type Pace, Player } from "./player.ts";

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

interface Owned {
    machine: Machine | undefined;
    knobs: Knobs | undefined;
    setKnobs(knobs: Knobs): void;
    use(head: PlayHead): Player;
}

// One that is there already stands still until a person lets time go by.
function useMachine(client: Client, newest: { current: ScopeChoice }, failed: (error: Error) => void): Owned {
    const [machine, setMachine] = useState<Machine>();
    const [knobs, setKnobs] = useState<Knobs>();
    const use = (head: PlayHead): Player => {
        const player = new Player(client, head.period_s, newest.current, failed);
        setMachine({ head, player });
        setKnobs(head.knobs);
        return player;
    };
    useEffect(() => {
        client.ask("playHead", null)
            .then((head) => (head === null ? undefined : use(head).setScope(newest.current)))
            .catch(failed);
    }, []);
    return { machine, knobs, setKnobs, use };
}

export function usePlay(client: Client, scope: ScopeChoice): Play {
    const [running, setRunning] = useState(false);
    const [problem, setProblem] = useState("");
    const newest = useRef(scope);
    newest.current = scope;
    const failed = (error: Error): void => setProblem(error.message);
    const { machine, knobs, setKnobs, use } = useMachine(client, newest, failed);
    const player = machine?.player;
    useRefresh();
    useEffect(() => () => player?.pause(), [player]);

    const go = (on: boolean, whose = player): void => {
        on ? whose?.run() : whose?.pause();
        setRunning(on);
    };
    const begin = async (selection: Selection): Promise<void> => {
        go(false);
        setProblem("");
        try {
            const choice = await preparedChoice(client, selection);
            go(true, use(await client.ask("playStart", { choice, scope: newest.current })));
        } catch (error) {
            failed(error as Error);
        }
    };
    return {
        head: machine?.head, knobs, player, block: player?.block, running, problem, begin,
        pace: player?.pace ?? { ratio: 0, frames: 0, dropped: 0 },
        setRunning: (on) => go(on),
        act: (act) => {
            setProblem("");
            player?.act(act).then(setKnobs).catch(failed);
        },
        setScope: (next) => void player?.setScope(next).catch(failed),
    };
}
