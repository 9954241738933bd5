// SPDX-License-Identifier: MIT
// The figures of a run beside their limits, its faults and notes, and what the drive takes for the motor's parameters.
import type { Fault, Parameter, ResultRow, Run } from "../core/protocol.ts";
import { shown, unitOfName, withUnit } from "../parts/format.ts";

function verdict(row: ResultRow): string {
    if (row.limit === "") {
        return "";
    }
    return row.holds ? "✓ ok" : "✗ not met";
}

// At its underscores.
function breakable(name: string) {
    return name.split("_").flatMap((word, index) => (index === 0 ? [word] : ["_", <wbr key={index} />, word]));
}

function valueOf({ name, value }: ResultRow): string {
    return withUnit(value, Number.isNaN(Number(value)) ? "" : unitOfName(name));
}

function Row({ row, before }: { row: ResultRow; before: ResultRow[] | undefined }) {
    const then = before?.find(({ name }) => name === row.name);
    return (
        <tr class={row.limit !== "" && !row.holds ? "broken" : ""}>
            <th scope="row">{breakable(row.name)}</th>
            <td>{valueOf(row)}</td>
            {before !== undefined && <td class="before">{then === undefined ? "" : valueOf(then)}</td>}
            <td>{row.limit}</td>
            <td>{verdict(row)}</td>
        </tr>
    );
}

function Figures({ run, before }: { run: Run; before: Run | undefined }) {
    return (
        <table>
            <caption>{run.accepted ? "Results: all limits hold" : "Results: a limit is not met"}</caption>
            <thead>
                <tr>
                    <th scope="col">Figure</th>
                    <th scope="col">Value</th>
                    {before !== undefined && <th scope="col">Before</th>}
                    <th scope="col">Limit</th>
                    <th scope="col">Verdict</th>
                </tr>
            </thead>
            <tbody>{run.rows.map((row) => <Row key={row.name} row={row} before={before?.rows} />)}</tbody>
        </table>
    );
}

function Parameters({ parameters }: { parameters: Parameter[] }) {
    return (
        <table>
            <caption>The motor as the drive knows it</caption>
            <thead>
                <tr>
                    <th scope="col">Parameter</th>
                    <th scope="col">Estimated</th>
                    <th scope="col">Actual</th>
                    <th scope="col">Configured</th>
                </tr>
            </thead>
            <tbody>
                {parameters.map((p) => (
                    <tr key={p.name}>
                        <th scope="row">{p.name}</th>
                        <td>{shown(p.estimated)}</td>
                        <td>{shown(p.actual)}</td>
                        <td>{shown(p.configured)}</td>
                    </tr>
                ))}
            </tbody>
        </table>
    );
}

function FaultCard({ fault }: { fault: Fault }) {
    return (
        <div class="fault" role="note">
            <strong>{`${fault.name} at ${shown(fault.time_s)} s`}</strong>
            <p>{fault.measure}</p>
            <p>{fault.advice}</p>
        </div>
    );
}

// Busy while a newer run is under way.
export function Results({ run, before, busy }: { run: Run; before: Run | undefined; busy: boolean }) {
    return (
        <section class="results scroll" aria-label="Results" aria-busy={busy} tabIndex={0}>
            <h2>{run.head.title}</h2>
            <p class="note">{`${run.head.motor}, ${run.head.board}, tuning ${run.head.tuning}`}</p>
            {run.faults.map((fault) => <FaultCard key={fault.time_s} fault={fault} />)}
            {run.notes.map((note) => <p key={note} class="note">{`Note: ${note}`}</p>)}
            <Figures run={run} before={before} />
            <Parameters parameters={run.parameters} />
        </section>
    );
}
