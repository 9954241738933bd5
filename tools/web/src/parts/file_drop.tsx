// SPDX-License-Identifier: MIT
// A place to drop a file, with a field to choose one.
import { useId, useState } from "preact/hooks";

interface Props {
    text: string; // what belongs here
    label: string; // of the field
    isDisabled?: boolean;
    open(file: File): void;
}

export function FileDrop({ text, label, isDisabled = false, open }: Props) {
    const id = useId();
    const [over, setOver] = useState(false);
    const take = (files: FileList | null | undefined): void => {
        const file = files?.[0];
        if (file !== undefined && !isDisabled) {
            open(file);
        }
    };
    return (
        <div
            class={over ? "drop over" : "drop"}
            onDragOver={(event) => {
                event.preventDefault();
                setOver(true);
            }}
            onDragLeave={() => setOver(false)}
            onDrop={(event) => {
                event.preventDefault();
                setOver(false);
                take(event.dataTransfer?.files);
            }}
        >
            <p>{text}</p>
            <label for={id}>{label}</label>{" "}
            <input
                id={id} type="file" disabled={isDisabled}
                onClick={({ currentTarget }) => (currentTarget.value = "")} // the same file, mended, can be chosen again
                onChange={(event) => take(event.currentTarget.files)}
            />
        </div>
    );
}
