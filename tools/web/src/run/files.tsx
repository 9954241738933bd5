// SPDX-License-Identifier: MIT
// The files of what is run, each in the editor.
import { useEffect, useState } from "preact/hooks";
import type { Client } from "../core/client.ts";
import type { Problem, SchemaKey } from "../core/protocol.ts";
import { FileEditor } from "../parts/file_editor.tsx";
import { download } from "../parts/format.ts";
import { type BenchFile, choiceOf, filesOf, type Parts, type Selection } from "./bench_state.ts";

interface Props {
    client: Client;
    schema: SchemaKey[];
    selection: Selection;
    parts: Parts;
    onSelect(selection: Selection): void;
}

const DATA_FOLDER = "/host_sim";

// Without the changes of one file.
function reverted(selection: Selection, path: string): Selection {
    return { ...selection, edits: Object.fromEntries(Object.entries(selection.edits).filter(([name]) => name !== path)) };
}

// The file on its own, then all of them together.
async function check({ client, selection, parts }: Props, { kind, path }: BenchFile, text: string): Promise<Problem[]> {
    const edited = { ...selection, edits: { ...selection.edits, [path]: text } };
    await client.ask("writeFiles", { files: edited.edits });
    return client.ask("check", { kind, file: path, text, choice: choiceOf(edited, parts) });
}

function Editor({ file, shipped, props, reset }: { file: BenchFile; shipped: string; props: Props; reset(): void }) {
    const { selection, onSelect, schema } = props;
    const text = selection.edits[file.path] ?? shipped;
    const change = (now: string): void =>
        onSelect(now === shipped
            ? reverted(selection, file.path)
            : { ...selection, edits: { ...selection.edits, [file.path]: now } });
    return (
        <>
            <div class="buttons">
                <button type="button" disabled={!(file.path in selection.edits)} onClick={reset}>Undo all changes</button>
                <button type="button" onClick={() => download(`${file.name}.toml`, new Blob([text]))}>Download file</button>
                <span class="note">Ctrl+Space completes a key. Escape, then Tab leaves the text.</span>
            </div>
            <FileEditor
                label={`${file.kind} file ${file.name}`} kind={file.kind} text={text} schema={schema}
                check={(now) => check(props, file, now)} onChange={change}
            />
        </>
    );
}

export function Files(props: Props) {
    const files = filesOf(props.selection, props.parts);
    const [path, setPath] = useState(files[0]?.path);
    const [shipped, setShipped] = useState<{ path: string; text: string }>();
    const [begun, setBegun] = useState(0); // a new editor a number
    const file = files.find((one) => one.path === path) ?? files[0];
    useEffect(() => {
        if (file !== undefined) {
            void props.client
                .ask("readFile", { path: `${DATA_FOLDER}/${file.path}` })
                .then((text) => setShipped({ path: file.path, text }));
        }
    }, [file?.path]);
    const reset = (): void => {
        props.onSelect(reverted(props.selection, file?.path ?? ""));
        setBegun(begun + 1);
    };
    return (
        <div class="files">
            <div class="buttons" role="group" aria-label="Files">
                {files.map((one) => (
                    <button type="button" key={one.path} aria-pressed={one === file} onClick={() => setPath(one.path)}>
                        {`${one.path}${one.path in props.selection.edits ? " *" : ""}`}
                    </button>
                ))}
            </div>
            {file !== undefined && shipped?.path === file.path && (
                <Editor key={`${file.path} ${begun}`} file={file} shipped={shipped.text} props={props} reset={reset} />
            )}
        </div>
    );
}
