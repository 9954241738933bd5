// SPDX-License-Identifier: MIT
// Who wants to hear that something has changed.

export class Listeners {
    private readonly all = new Set<() => void>();

    // Gives the function that ends this.
    add(hear: () => void): () => void {
        this.all.add(hear);
        return () => this.all.delete(hear);
    }

    tell(): void {
        this.all.forEach((hear) => hear());
    }
}
