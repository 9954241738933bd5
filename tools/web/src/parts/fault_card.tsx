// SPDX-License-Identifier: MIT
// The fault that a drive has, and what to do about it.
import type { Fault } from "../core/protocol.ts";
import { shown } from "./format.ts";

export function FaultCard({ fault }: { fault: Fault | null }) {
    return (
        <div role="alert">
            {fault !== null && (
                <div class="fault">
                    <strong>{`${fault.name} at ${shown(fault.time_s)} s`}</strong>
                    <p>{fault.measure}</p>
                    <p>{fault.advice}</p>
                    <p class="note">Repair what is broken, press Clear fault, then Run.</p>
                </div>
            )}
        </div>
    );
}
