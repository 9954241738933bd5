// SPDX-License-Identifier: MIT
// The keys of the board's files with their values, asked for anew after each change.
import { useEffect, useState } from "preact/hooks";
import type { LiveKey } from "../core/protocol.ts";
import type { Answer } from "./dialogue.ts";
import type { Talk } from "./talk.ts";

export interface Keys {
    all: LiveKey[];
    problem: string; // why they are not known
    isAsking: boolean;
    answer: (Answer & { key: string }) | undefined; // to the newest `set`
    set(key: string, value: string): Promise<Answer>;
    execute(line: string): Promise<void>; // one that may change them
}

export function useKeys(talk: Talk, isThere: boolean): Keys {
    const [all, setAll] = useState<LiveKey[]>([]);
    const [problem, setProblem] = useState("");
    const [isAsking, setIsAsking] = useState(false);
    const [answer, setAnswer] = useState<Keys["answer"]>();
    const ask = async (): Promise<void> => {
        setIsAsking(true);
        try {
            setAll(await talk.keys());
            setProblem("");
        } catch (error) {
            setProblem((error as Error).message);
        }
        setIsAsking(false);
    };
    useEffect(() => {
        if (isThere) {
            void ask();
        }
    }, [isThere]);
    const told = async (line: string): Promise<Answer> => {
        const given = await talk.execute(line);
        if (!given.refused) {
            await ask();
        }
        return given;
    };
    return {
        all, problem, isAsking, answer,
        set: async (key, value) => {
            setAnswer(undefined);
            const given = await told(`set ${key}=${value}`);
            setAnswer({ key, ...given });
            return given;
        },
        execute: async (line) => void (await told(line)),
    };
}
