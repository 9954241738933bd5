/* SPDX-License-Identifier: MIT */
// One machine out of the box, and how a drive that believes the files does on it.
#pragma once

#include "box.h"
#include "margins.h"

#include <cstdint>
#include <string>
#include <vector>

namespace nf::certify
{

// What became of a run, from good to bad.
enum class Verdict {
    held,
    slow,    // the rotor is held, but a speed is not reached within 5 %
    stopped, // a latched fault, gates open
    lost,    // the rotor was lost without a fault
};
const char *verdict_text(Verdict verdict);

// The rotor is held all the time.
inline bool is_locked(Verdict verdict)
{
    return verdict == Verdict::held || verdict == Verdict::slow;
}

// A value of each axis of a box, in its order.
using Point = std::vector<double>;

struct Trial {
    Verdict verdict = Verdict::lost;
    std::string fault; // the first one's name; empty without one
    bool swings = false;
    Margins margins;

    // The least margin; 0 where the rotor was not held.
    double worst() const;
};

// Machine number `run` of a seed. It depends on these and the axis alone: another axis, or more
// runs, leave it as it is.
Point draw_point(const std::vector<Axis> &box, uint64_t seed, int run);

// Of that machine, for the noise of its sensors.
unsigned noise_seed(uint64_t seed, int run);

// Throws ConfigError where no such machine can be simulated.
Trial try_point(const Config &believed, const std::vector<Axis> &box, const Point &point,
                unsigned noise);

} // namespace nf::certify
