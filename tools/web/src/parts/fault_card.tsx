// SPDX-License-Identifier: MIT
// The fault that a drive has, and what to do about it.
import type { Fault } from "../core/protocol.ts";
import { shown } from "./format.ts";

// `isPast`: it is the last one that is known, and may not be there any more.
export function FaultCard({ fault, isPast = false }: { fault: Fault | null; isPast?: boolean }) {
    return (
        <div role="alert">
            {fault !== null && (
                <div class="fault">
                    <strong>{`${isPast ? "The last known fault: " : ""}${fault.name} at ${shown(fault.time_s)} s`}</strong>
                    <p>{fault.measure}</p>
                    <p>{fault.advice}</p>
                    <p class="note">Repair what is broken, press Clear fault, then Start motor.</p>
                </div>
            )}
        </div>
    );
}
