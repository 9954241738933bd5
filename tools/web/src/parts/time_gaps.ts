// SPDX-License-Identifier: MIT
// Where a curve is not drawn across: its times jump. NaN in the columns would not do, because a canvas leaves such a point out
// and draws on to the next one.
import type uPlot from "uplot";

const JUMP = 1.5; // of the distance over one point between: three distances of neighbours

// The points behind a jump.
export function jumps(times: ArrayLike<number>): number[] {
    const at = (index: number): number => times[index] ?? NaN;
    let twice = Infinity; // neighbours do not all have the same distance, every other point does
    for (let index = 2; index < times.length; index++) {
        twice = Math.min(twice, at(index) - at(index - 2));
    }
    const found = [];
    for (let index = 1; index < times.length; index++) {
        if (at(index) - at(index - 1) > JUMP * twice) {
            found.push(index);
        }
    }
    return found;
}

// As a plot wants them of a series.
export function gapsOfTimes(plot: uPlot): [number, number][] {
    const times = plot.data[0];
    const px = (index: number): number => Math.round(plot.valToPos(times[index] ?? NaN, "x", true));
    return jumps(times).map((index) => [px(index - 1), px(index)]);
}
