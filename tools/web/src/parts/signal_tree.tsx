// SPDX-License-Identifier: MIT
// All signals by their names' parts, to search by name and unit and to choose from.
import { useId, useState } from "preact/hooks";
import type { SignalInfo } from "../core/protocol.ts";

interface Props {
    signals: SignalInfo[];
    chosen: ReadonlySet<string>;
    onToggle(name: string): void;
}

const RUN_GROUP = "run";

// Words of the firmware have dots: "drive.control.voltage.d" is of drive.control.voltage. The others are of the run.
function groupOf(name: string): string {
    const parts = name.split(".");
    return parts.length === 1 ? RUN_GROUP : parts.slice(0, Math.min(2, parts.length - 1)).join(".");
}

function grouped(signals: SignalInfo[]): Map<string, SignalInfo[]> {
    const groups = new Map<string, SignalInfo[]>();
    for (const signal of signals) {
        const group = groupOf(signal.name);
        groups.set(group, [...(groups.get(group) ?? []), signal]);
    }
    return groups;
}

// "N m" and "n·m" are one unit.
function plainUnit(text: string): string {
    return text.toLowerCase().replaceAll(/[\s·]/g, "");
}

// Each word has to be in the name, or be the unit.
function matches({ name, unit }: SignalInfo, search: string): boolean {
    const words = search.toLowerCase().split(/\s+/).filter((word) => word !== "");
    return words.every((word) => name.toLowerCase().includes(word) || plainUnit(unit) === plainUnit(word));
}

function Signal({ signal, props }: { signal: SignalInfo; props: Props }) {
    return (
        <li>
            <label title={signal.format}>
                <input
                    type="checkbox"
                    checked={props.chosen.has(signal.name)}
                    onChange={() => props.onToggle(signal.name)}
                />
                <span class="signal-name">{signal.name}</span>
                <span class="unit">{signal.unit}</span>
            </label>
        </li>
    );
}

export function SignalTree(props: Props) {
    const id = useId();
    const [search, setSearch] = useState("");
    const found = props.signals.filter((signal) => matches(signal, search));
    return (
        <section class="signal-tree" aria-label="Signals">
            <label for={id}>Search signals by name or unit</label>
            <input id={id} type="search" value={search} onInput={(event) => setSearch(event.currentTarget.value)} />
            <p class="note" role="status">{`${found.length} of ${props.signals.length} signals`}</p>
            <div class="scroll" tabIndex={0} role="group" aria-label="Signals found">
                {[...grouped(found)].map(([group, signals]) => (
                    <details key={group} open={search !== "" || group === RUN_GROUP}>
                        <summary>{`${group} (${signals.length})`}</summary>
                        <ul>{signals.map((signal) => <Signal key={signal.name} signal={signal} props={props} />)}</ul>
                    </details>
                ))}
            </div>
        </section>
    );
}
