// SPDX-License-Identifier: MIT
// A configuration file in an editor: keys are completed, explained under the pointer, and errors stand at their line.
import { autocompletion, closeBrackets, completionKeymap, type Completion, type CompletionContext, type CompletionResult } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
import { HighlightStyle, StreamLanguage, syntaxHighlighting } from "@codemirror/language";
import { toml } from "@codemirror/legacy-modes/mode/toml";
import { linter, lintGutter, lintKeymap, type Diagnostic } from "@codemirror/lint";
import { EditorState, type Extension } from "@codemirror/state";
import { drawSelection, EditorView, highlightActiveLine, hoverTooltip, keymap, lineNumbers } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import { useEffect, useRef } from "preact/hooks";
import type { FileKind, Problem, SchemaKey } from "../core/protocol.ts";
import { Keys, rangeText, sectionAt } from "./toml_keys.ts";

interface Props {
    label: string; // for screen readers
    kind: FileKind;
    text: string; // when the editor begins; another `key` begins another one
    schema: SchemaKey[];
    check(text: string): Promise<Problem[]>;
    onChange(text: string): void;
}

const LINT_DELAY_MS = 250;

const COLOURS = HighlightStyle.define([
    { tag: tags.comment, color: "var(--text-soft)" },
    { tag: [tags.string, tags.special(tags.string)], color: "var(--code-string)" },
    { tag: [tags.number, tags.bool, tags.atom], color: "var(--code-number)" },
    { tag: [tags.propertyName, tags.definition(tags.propertyName)], color: "var(--code-key)" },
]);

function optionOf(key: SchemaKey): Completion {
    return { label: key.key, detail: key.allowed, info: `${key.meaning}. ${rangeText(key)}`, apply: `${key.key} = ` };
}

// Keys at the start of a line, sections behind its bracket.
function completer(keys: Keys) {
    return (context: CompletionContext): CompletionResult | null => {
        const header = context.matchBefore(/^\s*\[\[?[\w.]*/);
        if (header !== null) {
            const from = header.from + header.text.lastIndexOf("[") + 1;
            return { from, options: keys.sections().map((label) => ({ label, type: "namespace" })) };
        }
        const word = context.matchBefore(/^\s*\w*/);
        if (word === null || (word.text.trim() === "" && !context.explicit)) {
            return null;
        }
        const section = sectionAt(context.state.doc, context.state.doc.lineAt(context.pos).number);
        const from = word.from + word.text.length - word.text.trimStart().length;
        return { from, options: keys.in(section).map(optionOf) };
    };
}

function tooltipText(key: SchemaKey): HTMLElement {
    const box = document.createElement("div");
    box.className = "key-help";
    for (const text of [`${key.section}.${key.key}`, key.meaning, rangeText(key)]) {
        box.append(Object.assign(document.createElement("p"), { textContent: text }));
    }
    return box;
}

function explainer(keys: Keys): Extension {
    return hoverTooltip((view, at) => {
        const line = view.state.doc.lineAt(at);
        const written = /^\s*([\w.]+)\s*=/.exec(line.text)?.[1];
        const key = written === undefined ? undefined : keys.find(sectionAt(view.state.doc, line.number), written);
        return key === undefined
            ? null
            : { pos: line.from, end: line.to, above: true, create: () => ({ dom: tooltipText(key) }) };
    });
}

// What the program says of no line stands at the first one.
function diagnosticOf({ line, text }: Problem, state: EditorState): Diagnostic {
    const at = state.doc.line(Math.min(Math.max(line, 1), state.doc.lines));
    return { from: at.from, to: at.to, severity: "error", message: text };
}

function checker(check: () => Props["check"]): Extension {
    return linter(
        async (view) => (await check()(view.state.doc.toString())).map((problem) => diagnosticOf(problem, view.state)),
        { delay: LINT_DELAY_MS },
    );
}

function extensionsOf(props: Props, latest: { current: Props }): Extension[] {
    const keys = new Keys(props.schema, props.kind);
    return [
        lineNumbers(), lintGutter(), history(), drawSelection(), highlightActiveLine(), closeBrackets(),
        StreamLanguage.define(toml), syntaxHighlighting(COLOURS),
        autocompletion({ override: [completer(keys)] }), explainer(keys), checker(() => latest.current.check),
        keymap.of([...completionKeymap, ...lintKeymap, ...historyKeymap, ...defaultKeymap]),
        EditorView.contentAttributes.of({ "aria-label": props.label }),
        EditorView.updateListener.of((update) => {
            if (update.docChanged) {
                latest.current.onChange(update.state.doc.toString());
            }
        }),
    ];
}

export function FileEditor(props: Props) {
    const box = useRef<HTMLDivElement>(null);
    const latest = useRef(props);
    latest.current = props;
    useEffect(() => {
        const state = EditorState.create({ doc: props.text, extensions: extensionsOf(props, latest) });
        const view = new EditorView({ state, parent: box.current as HTMLDivElement });
        view.scrollDOM.tabIndex = 0; // for keys that scroll
        return () => view.destroy();
    }, []);
    return <div class="editor" ref={box} />;
}
