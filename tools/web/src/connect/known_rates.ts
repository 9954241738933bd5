// SPDX-License-Identifier: MIT
// Rates at which a board may answer, as `motorsim live` tries them: those of the shipped boards, and the one of a board file that
// names none; the highest first.
import type { Client } from "../core/client.ts";
import { folderOf, type Names, type SchemaKey } from "../core/protocol.ts";

const LINE = /^\s*baud\s*=\s*(\d+)/m;

async function rateOf(client: Client, board: string): Promise<number | undefined> {
    const text = await client.ask("readFile", { path: `/host_sim/${folderOf("board")}/${board}.toml` });
    const written = LINE.exec(text)?.[1];
    return written === undefined ? undefined : Number(written);
}

export async function knownRates(client: Client, names: Names, schema: SchemaKey[]): Promise<number[]> {
    const unwritten = schema.find(({ section, key }) => section === "board" && key === "baud")?.default;
    const written = await Promise.all(names.board.map((board) => rateOf(client, board)));
    const rates = [Number.parseInt(unwritten ?? ""), ...written].filter((rate): rate is number => (rate ?? NaN) > 0);
    return [...new Set(rates)].sort((one, other) => other - one);
}
