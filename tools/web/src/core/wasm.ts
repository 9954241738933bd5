// SPDX-License-Identifier: MIT
// The simulator as compiled: its file system and its one function.
import { FILE_KINDS, folderOf, type Requests } from "./protocol.ts";
import type { Line } from "./shared_line.ts";

interface FileSystem {
    readFile(path: string, options: { encoding: "utf8" }): string;
    readFile(path: string): Uint8Array<ArrayBuffer>;
    writeFile(path: string, content: string | Uint8Array): void;
    mkdir(path: string): void;
    chdir(path: string): void;
    unlink(path: string): void;
}

export interface Module {
    FS: FileSystem;
    HEAPF32: Float32Array;
    HEAPF64: Float64Array;
    UTF8ToString(address: number): string;
    stringToUTF8(text: string, address: number, bytes: number): void;
    lengthBytesUTF8(text: string): number;
    _malloc(bytes: number): number;
    _free(address: number): void;
    _nf_web_call(name: number, given: number): number;
    line?: Line; // of the board that is followed
}

export interface Block {
    address: number;
    count: number;
}

// The folder that the program works in: edited files lie there.
export const WORK_FOLDER = "/bench";
// For one file that a person has dropped, under its own name.
const DROP_FOLDER = "/dropped";
const DATA_FOLDER = "/host_sim";

// Of the simulator: an error of the user's files, in the program's words.
export class CoreError extends Error {}

export class Core {
    private written: string[] = [];

    constructor(private readonly module: Module) {
        module.FS.mkdir(WORK_FOLDER);
        FILE_KINDS.forEach((kind) => module.FS.mkdir(`${WORK_FOLDER}/${folderOf(kind)}`));
        module.FS.mkdir(DROP_FOLDER);
        module.FS.chdir(WORK_FOLDER);
    }

    call<Value>(name: string, given: unknown): Value {
        const texts = [this.textAt(name), this.textAt(JSON.stringify(given))] as const;
        try {
            const answer = this.module.UTF8ToString(this.module._nf_web_call(...texts));
            const { value, error } = JSON.parse(answer) as { value?: Value; error?: string };
            if (error !== undefined) {
                throw new CoreError(error);
            }
            return value as Value;
        } finally {
            texts.forEach((address) => this.module._free(address));
        }
    }

    useLine(line: Line): void {
        this.module.line = line;
    }

    floats(block: Block): Float32Array {
        const from = block.address / Float32Array.BYTES_PER_ELEMENT;
        return this.module.HEAPF32.slice(from, from + block.count);
    }

    doubles(block: Block): Float64Array {
        const from = block.address / Float64Array.BYTES_PER_ELEMENT;
        return this.module.HEAPF64.slice(from, from + block.count);
    }

    columns(blocks: Record<string, Block>): Record<string, Float32Array> {
        return Object.fromEntries(Object.entries(blocks).map(([name, block]) => [name, this.floats(block)]));
    }

    read(path: string): string {
        return this.module.FS.readFile(path, { encoding: "utf8" });
    }

    // Of the work folder these and no others are there, each in a folder that is there already.
    writeFiles(files: Requests["writeFiles"]["given"]["files"]): void {
        const fs = this.module.FS;
        this.written.forEach((name) => fs.unlink(`${WORK_FOLDER}/${name}`));
        this.written = Object.keys(files);
        for (const [name, text] of Object.entries(files)) {
            fs.writeFile(`${WORK_FOLDER}/${name}`, text);
        }
    }

    // By their names, beside the shipped ones: the program finds them as it finds those.
    addMotors(motors: Record<string, string>): void {
        for (const [name, text] of Object.entries(motors)) {
            this.module.FS.writeFile(`${DATA_FOLDER}/${folderOf("motor")}/${name}.toml`, text);
        }
    }

    // The call finds the file by its bare name, which its errors begin with.
    callWithFile<Value>(name: string, file: string, bytes: Uint8Array): Value {
        const fs = this.module.FS;
        fs.chdir(DROP_FOLDER);
        try {
            fs.writeFile(file, bytes);
            return this.call<Value>(name, { file });
        } finally {
            fs.unlink(file);
            fs.chdir(WORK_FOLDER);
        }
    }

    // Read and removed.
    take(path: string): string {
        const text = this.read(path);
        this.module.FS.unlink(path);
        return text;
    }

    takeBytes(path: string): Uint8Array<ArrayBuffer> {
        const bytes = this.module.FS.readFile(path);
        this.module.FS.unlink(path);
        return bytes;
    }

    private textAt(text: string): number {
        const bytes = this.module.lengthBytesUTF8(text) + 1;
        const address = this.module._malloc(bytes);
        this.module.stringToUTF8(text, address, bytes);
        return address;
    }
}
