// SPDX-License-Identifier: MIT
// Shows anew what a person reads, now and then: as often as it changes it could not be read.
import { useEffect, useState } from "preact/hooks";

const REFRESH_MS = 100;

export function useRefresh(): void {
    const [, refresh] = useState(0);
    useEffect(() => {
        const timer = setInterval(() => refresh((count) => count + 1), REFRESH_MS);
        return () => clearInterval(timer);
    }, []);
}
