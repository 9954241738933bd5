// SPDX-License-Identifier: MIT
// The drive's states and which may follow which, as the firmware has them; the present one, or the last that is known, is lit. Left
// out are the moves that each running state has: STOP to READY, and a fault.

interface Move {
    from: string;
    to: string;
}

// Column and row.
const PLACES: Record<string, [number, number]> = {
    INIT: [0, 0], OFFSET_CAL: [1, 0], READY: [2, 0], PROBE: [3, 0],
    FAULT: [0, 1], RUN: [1, 1], FLYING_START: [2, 1], ALIGN: [3, 1],
    HANDOVER: [1, 2], IF_RAMP: [2, 2], HOLD: [3, 2],
};
const [WIDTH, HEIGHT, COLUMN, ROW] = [92, 26, 112, 50];
const BEFORE_RUNNING = ["INIT", "OFFSET_CAL", "FAULT"];

type Point = [number, number];

function centre(name: string): Point {
    const [column, row] = PLACES[name] ?? [0, 3];
    return [column * COLUMN + WIDTH / 2, row * ROW + HEIGHT / 2];
}

// Where a line from the centre of a box leaves it.
function border([x, y]: Point, [toX, toY]: Point): Point {
    const [dx, dy] = [toX - x, toY - y];
    const share = Math.min(WIDTH / 2 / Math.abs(dx || 1e-9), HEIGHT / 2 / Math.abs(dy || 1e-9));
    return [x + dx * share, y + dy * share];
}

function isDrawn({ from, to }: Move): boolean {
    const common = to === "FAULT" || (to === "READY" && !BEFORE_RUNNING.includes(from));
    return from !== to && !common;
}

function Arrow({ from, to }: Move) {
    const [x1, y1] = border(centre(from), centre(to));
    const [x2, y2] = border(centre(to), centre(from));
    return <line x1={x1} y1={y1} x2={x2} y2={y2} class="move" marker-end="url(#arrow)" />;
}

function State({ name, lit }: { name: string; lit: boolean }) {
    const [x, y] = centre(name);
    const kind = name === "FAULT" ? "state fault-state" : "state";
    return (
        <g class={lit ? `${kind} lit` : kind}>
            <rect x={x - WIDTH / 2} y={y - HEIGHT / 2} width={WIDTH} height={HEIGHT} rx={5} />
            <text x={x} y={y + 4}>{name}</text>
        </g>
    );
}

export function StateMachine({ moves, state, isPast = false }: { moves: Move[]; state: string; isPast?: boolean }) {
    const said = isPast ? `last known ${state}` : state;
    const names = [...new Set(moves.flatMap(({ from, to }) => [from, to]))];
    return (
        <section class={isPast ? "state-machine past" : "state-machine"} aria-label="State machine">
            <p class="note" role="status">{`State: ${said}`}</p>
            <svg
                viewBox={`-2 -2 ${3 * COLUMN + WIDTH + 4} ${2 * ROW + HEIGHT + 4}`} role="img"
                aria-label={`State machine; the ${isPast ? "last known" : "present"} state is ${state}`}
            >
                <defs>
                    <marker id="arrow" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">
                        <path d="M0 0 L8 4 L0 8 z" class="arrow" />
                    </marker>
                </defs>
                {moves.filter(isDrawn).map((move) => <Arrow key={`${move.from} ${move.to}`} {...move} />)}
                {names.map((name) => <State key={name} name={name} lit={name === state} />)}
            </svg>
            <p class="note">Any state goes to FAULT with a fault, a running one to READY with Stop.</p>
        </section>
    );
}
