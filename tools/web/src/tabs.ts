// SPDX-License-Identifier: MIT
// The parts of the bench; each is a row.
import type { ComponentType } from "preact";
import type { Client } from "./core/client.ts";
import type { Names, SchemaKey } from "./core/protocol.ts";
import { RunTab } from "./run/run_tab.tsx";

export interface TabProps {
    client: Client;
    names: Names;
    schema: SchemaKey[];
}

export interface Tab {
    id: string;
    title: string;
    view: ComponentType<TabProps>;
}

export const TABS: Tab[] = [{ id: "run", title: "Run", view: RunTab }];
