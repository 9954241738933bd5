// SPDX-License-Identifier: MIT
// What was said, with the newest line in sight.
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";

interface Props {
    label: string;
    said: readonly unknown[]; // another one with each change
    children: ComponentChildren;
}

export function SaidLog({ label, said, children }: Props) {
    const log = useRef<HTMLDivElement>(null);
    const toNewest = (): void => log.current?.scrollTo(0, log.current.scrollHeight);
    useEffect(toNewest, [said]);
    useEffect(() => {
        const sized = new ResizeObserver(toNewest);
        sized.observe(log.current as HTMLDivElement);
        return () => sized.disconnect();
    }, []);
    return <div class="scroll said" ref={log} tabIndex={0} role="log" aria-label={label}>{children}</div>;
}
