// SPDX-License-Identifier: MIT
// The files of what is run, each in the editor.
import { useEffect, useState } from "preact/hooks";
import type { Client } from "../core/client.ts";
import type { Parts, Problem, SchemaKey } from "../core/protocol.ts";
import type { FileEditor } from "../parts/file_editor.tsx";
import { download } from "../parts/format.ts";
import { type BenchFile, choiceOf, filesOf, type Selection, withText } from "./bench_state.ts";

interface Props {
    client: Client;
    schema: SchemaKey[];
    selection: Selection;
    parts: Parts;
    onSelect(selection: Selection): void;
}

const DATA_FOLDER = "/host_sim";

// What the view has to load before it shows a file.
interface Loaded {
    editor: typeof FileEditor; // a large part of the page, and not every visit needs it
    shipped: Record<string, string>; // texts by path
}

async function load(client: Client, files: BenchFile[]): Promise<Loaded> {
    const texts = files.map(async ({ path }) => [path, await client.ask("readFile", { path: `${DATA_FOLDER}/${path}` })]);
    const { FileEditor: editor } = await import("../parts/file_editor.tsx");
    return { editor, shipped: Object.fromEntries(await Promise.all(texts)) as Loaded["shipped"] };
}

// The file on its own, then all of them together.
async function check({ client, parts }: Props, { kind, path }: BenchFile, text: string, edited: Selection): Promise<Problem[]> {
    await client.ask("writeFiles", { files: edited.edits });
    return client.ask("check", { kind, file: path, text, choice: choiceOf(edited, parts) });
}

interface EditorProps {
    file: BenchFile;
    loaded: Loaded;
    props: Props;
}

function Editor({ file, loaded: { editor: TextEditor, shipped }, props }: EditorProps) {
    const { selection, parts, onSelect, schema } = props;
    const [begun, setBegun] = useState(0); // a new editor a number
    const text = selection.edits[file.path] ?? shipped[file.path] ?? "";
    const edited = (now: string): Selection => withText(selection, parts, shipped, file.path, now);
    const reset = (): void => {
        onSelect(edited(shipped[file.path] ?? ""));
        setBegun(begun + 1);
    };
    return (
        <>
            <div class="buttons">
                <button type="button" disabled={!(file.path in selection.edits)} onClick={reset}>Undo all changes</button>
                <button type="button" onClick={() => download(`${file.name}.toml`, new Blob([text]))}>Download file</button>
                <span class="note">Ctrl+Space completes a key. Escape, then Tab leaves the text.</span>
            </div>
            <TextEditor
                key={begun} label={`${file.kind} file ${file.name}`} kind={file.kind} text={text} schema={schema}
                check={(now) => check(props, file, now, edited(now))} onChange={(now) => onSelect(edited(now))}
            />
        </>
    );
}

export function Files(props: Props) {
    const files = filesOf(props.selection, props.parts);
    const paths = files.map(({ path }) => path).join();
    const [path, setPath] = useState(files[0]?.path);
    const [loaded, setLoaded] = useState<Loaded>();
    const [problem, setProblem] = useState("");
    const file = files.find((one) => one.path === path) ?? files[0];
    useEffect(() => {
        load(props.client, files).then(setLoaded, (error: Error) => setProblem(error.message));
    }, [paths]);
    return (
        <div class="files">
            <div class="buttons" role="group" aria-label="Files">
                {files.map((one) => (
                    <button type="button" key={one.path} aria-pressed={one === file} onClick={() => setPath(one.path)}>
                        {`${one.path}${one.path in props.selection.edits ? " *" : ""}`}
                    </button>
                ))}
            </div>
            {problem !== "" && <p class="problem" role="alert">{problem}</p>}
            {file !== undefined && loaded !== undefined && file.path in loaded.shipped && (
                <Editor key={file.path} file={file} loaded={loaded} props={props} />
            )}
        </div>
    );
}
