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

// As a plot wants them of a series, in order, with those of its unknown values.
export function gapsOfTimes(plot: uPlot, _series: number, _from: number, _to: number, ofNulls: uPlot.Series.Gaps): uPlot.Series.Gaps {
    const times = plot.data[0];
    const px = (index: number): number => Math.round(plot.valToPos(times[index] ?? NaN, "x", true));
    const ofTimes = jumps(times).map((index): [number, number] => [px(index - 1), px(index)]);
    let end = -Infinity; // of those before: a gap within another one must not end it
    return [...ofNulls, ...ofTimes].sort(([one], [other]) => one - other).map(([from, to]) => [from, (end = Math.max(end, to))]);
}
