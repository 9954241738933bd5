// SPDX-License-Identifier: MIT
// What a part of the bench is to the page, and the page to it.
import type { ComponentType } from "preact";
import type { Client } from "./core/client.ts";
import type { Names, SchemaKey } from "./core/protocol.ts";

export interface TabProps {
    // Opens another tab; `what` is for it.
    show(id: string, what?: string): void;
    what: string;
    client: Client;
    names: Names;
    schema: SchemaKey[];
}

export interface Tab {
    id: string;
    title: string;
    view: ComponentType<TabProps>;
}
