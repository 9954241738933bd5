/* SPDX-License-Identifier: MIT */
// Finds a swing that does not die out: a limit cycle, a resonance, or a ripple that something but
// the rotor's turning drives.
//
// A swing is sustained when three periods after any half-swing the signal still makes half-swings
// of at least half its height. A free swing with the damping ζ falls by exp(−2πζ/√(1−ζ²)) in a
// period, to a half in three of them for ζ = 0.037: what is reported has less damping than that,
// which is none that anybody designed. What a step sets off and the loop takes away is not
// reported, whatever its height.
//
// Half-swings are the ways between turning points. The signal turns where it has come back by
// `least` from its extreme: noise and ripple below that do not end a half-swing, and make none.
//
// What is watched may be a part of a signal: what is left of it once a ripple has been taken off.
// Taking off what is not there makes a swing that no machine has, one of speed without the torque
// for it. So the signal itself has to go the same ways, by half of their height in the sum of three
// periods.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace nf
{

struct Swing {
    double amplitude; // half of the height, mean of three periods
    double hz;
};

class SwingFinder
{
public:
    // `least` is the smallest height of a half-swing that counts, twice an amplitude.
    SwingFinder(double least, double period_s);

    // The conditions are other ones: what was seen so far says nothing of what comes.
    void restart();
    // What is left of the signal, and the signal.
    void add(double value, double signal);
    void add(double value)
    {
        add(value, value);
    }

    // The largest sustained swing since construction.
    const std::optional<Swing> &largest() const
    {
        return largest_;
    }

private:
    static constexpr std::size_t HALVES = 6; // half-swings of three periods

    struct Turn {
        int64_t tick;
        double value;
        double signal;
    };
    void turned_at(const Turn &found);
    void judge();

    double least_;
    double period_s_;
    int64_t tick_ = 0;
    bool begun_ = false;
    int direction_ = 0; // of the half-swing under way, 0: none yet
    Turn low_{};        // extremes since the last turning point
    Turn high_{};
    std::array<Turn, HALVES + 2> turns_{}; // the newest last
    std::size_t count_ = 0;
    std::optional<Swing> largest_;
};

} // namespace nf
