// SPDX-License-Identifier: MIT
// What a page shows as the end of its address: JSON, compressed, in characters that a link may hold.

async function through(stream: GenericTransformStream, bytes: Uint8Array<ArrayBuffer>): Promise<Uint8Array<ArrayBuffer>> {
    const piped = new Blob([bytes]).stream().pipeThrough(stream as ReadableWritablePair<Uint8Array<ArrayBuffer>>);
    return new Uint8Array(await new Response(piped).arrayBuffer());
}

export async function packed(state: unknown): Promise<string> {
    const text = new TextEncoder().encode(JSON.stringify(state)) as Uint8Array<ArrayBuffer>;
    const bytes = await through(new CompressionStream("deflate-raw"), text);
    const binary = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
    return btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

// Throws for what packed() has not made.
export async function unpacked(text: string): Promise<unknown> {
    const binary = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
    const bytes = Uint8Array.from(binary, (character) => character.charCodeAt(0));
    return JSON.parse(new TextDecoder().decode(await through(new DecompressionStream("deflate-raw"), bytes)));
}
