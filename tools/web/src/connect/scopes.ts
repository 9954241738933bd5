// SPDX-License-Identifier: MIT
// What of a board is drawn. It stays when the board has gone.
import type { LiveBlock, ScopeChoice } from "../core/protocol.ts";
import { FIRST_PANELS } from "../parts/board_panels.ts";
import { scopeChoice } from "../parts/scope_scene.tsx";
import { ScopeTrack } from "../parts/scope_track.ts";

const FIRST_SPAN_S = 5;

export class Scopes {
    panels = FIRST_PANELS;
    span = FIRST_SPAN_S;
    track = new ScopeTrack(this.choice);

    get choice(): ScopeChoice {
        return scopeChoice(this.panels, this.span);
    }

    // Of another connection.
    begin(): void {
        this.track = new ScopeTrack(this.choice);
    }

    // A page that nobody sees need not draw.
    take(block: LiveBlock): void {
        if (block.state !== "") {
            this.track.take(block);
        }
        if (!block.in_step) {
            this.track.breakOff();
        }
        if (!document.hidden) {
            this.track.drawn.tell();
        }
    }
}
