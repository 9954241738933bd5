// SPDX-License-Identifier: MIT
// The keys of the board's files with their values, asked for anew after each change.
import { useEffect, useState } from "preact/hooks";
import type { LiveKey, Said } from "../core/protocol.ts";
import type { Board } from "./board.ts";
import { Dropped } from "./turns.ts";

interface Known {
    all: LiveKey[];
    problem: string; // why they are not known
}

interface Asked extends Known {
    isAsking: boolean;
    ask(): void;
}

export interface Keys extends Asked {
    answer: (Said & { keys: string[] }) | undefined; // to the newest `set`
    set(values: [key: string, value: string][]): Promise<Said>; // which act together
}

const NOTHING: Known = { all: [], problem: "" };

// A stop drops the question as well; it is asked again.
async function asked(board: Board): Promise<Known> {
    try {
        return { all: await board.talk.keys(), problem: "" };
    } catch (error) {
        const isWanted = error instanceof Dropped && board.phase === "following";
        return isWanted ? asked(board) : { all: [], problem: (error as Error).message };
    }
}

// Of a board that has gone none are known.
function useAsked(board: Board): Asked {
    const isThere = board.phase === "following";
    const [known, setKnown] = useState(NOTHING);
    const [isAsking, setIsAsking] = useState(false);
    const ask = async (): Promise<void> => {
        setIsAsking(true);
        const next = await asked(board);
        setKnown(board.phase === "following" ? next : NOTHING);
        setIsAsking(false);
    };
    useEffect(() => {
        setKnown(NOTHING);
        if (!isThere) {
            return undefined;
        }
        void ask();
        return board.talk.configured.add(() => void ask());
    }, [isThere]);
    return { ...known, isAsking, ask: () => void ask() };
}

export function useKeys(board: Board): Keys {
    const known = useAsked(board);
    const [answer, setAnswer] = useState<Keys["answer"]>();
    useEffect(() => setAnswer(undefined), [board.phase === "following"]);
    return {
        ...known, answer,
        set: async (values) => {
            setAnswer(undefined);
            const said = await board.talk.execute(`set ${values.map((pair) => pair.join("=")).join(" ")}`);
            setAnswer({ keys: values.map(([key]) => key), ...said });
            return said;
        },
    };
}
