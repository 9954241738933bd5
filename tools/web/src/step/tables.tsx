// SPDX-License-Identifier: MIT
// The present tick: its stages in their order, and the same tick beside double precision.
import type { DiffRow, SignalValue, StepView } from "../core/protocol.ts";
import { shown, significant } from "../parts/format.ts";

const DIGITS = 6;

function precise(value: number): string {
    return significant(value, DIGITS);
}

function valueText({ value, unit, word }: SignalValue): string {
    if (word !== undefined && word !== "") {
        return word;
    }
    return value === null ? "–" : `${precise(value)}${unit === "" ? "" : ` ${unit}`}`;
}

function Signal({ row, recorded }: { row: SignalValue; recorded: boolean }) {
    const departs = row.recorded !== undefined && row.recorded !== row.raw;
    return (
        <tr class={departs ? "broken" : ""}>
            <th scope="row">{row.name}</th>
            <td>{valueText(row)}</td>
            <td>{row.raw ?? ""}</td>
            <td class="format">{row.format ?? ""}</td>
            {recorded && <td>{`${row.recorded ?? ""}${departs ? " ✗" : ""}`}</td>}
        </tr>
    );
}

export function Stages({ view, recorded }: { view: StepView; recorded: boolean }) {
    const columns = ["Signal", "Value", "Raw word", "Format", ...(recorded ? ["Recorded"] : [])];
    return (
        <table class="stages">
            <caption>{`Stages of tick ${view.tick}, in the order in which the drive computes them`}</caption>
            <thead><tr>{columns.map((name) => <th scope="col" key={name}>{name}</th>)}</tr></thead>
            {view.stages.map(({ title, rows }) => (
                <tbody key={title}>
                    <tr class="stage-title"><th scope="rowgroup" colSpan={columns.length}>{title}</th></tr>
                    {rows.map((row) => <Signal key={row.name} row={row} recorded={recorded} />)}
                </tbody>
            ))}
        </table>
    );
}

function Difference({ row }: { row: DiffRow }) {
    return (
        <tr class={row.departs ? "broken" : ""}>
            <th scope="row">{`${row.module}: ${row.quantity}`}</th>
            <td>{precise(row.drive)}</td>
            <td>{precise(row.reference)}</td>
            <td>{row.unit}</td>
            <td>{shown(Math.abs(row.drive - row.reference))}</td>
            <td>{shown(row.tolerance)}</td>
            <td>{row.departs ? "✗ departs" : "✓"}</td>
        </tr>
    );
}

export function Diff({ view }: { view: StepView }) {
    const departures = view.diff.filter(({ departs }) => departs);
    return (
        <table>
            <caption>
                {departures.length === 0
                    ? `Tick ${view.tick} beside double precision: ${view.diff.length} values within their roundings`
                    : `Tick ${view.tick} beside double precision: first departure in ${departures[0]?.module}, ${departures[0]?.quantity}`}
            </caption>
            <thead>
                <tr>
                    {["Function: quantity", "Drive", "Reference", "Unit", "Apart", "Tolerance", "Verdict"].map((name) => (
                        <th scope="col" key={name}>{name}</th>
                    ))}
                </tr>
            </thead>
            <tbody>{view.diff.map((row, index) => <Difference key={index} row={row} />)}</tbody>
        </table>
    );
}
