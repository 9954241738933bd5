/* SPDX-License-Identifier: MIT */
// What goes wrong in a run: [[scenario.fault]] put into the plant, the hardware binding and the
// drive's memory at its time. Where no fault is listed nothing is touched.
#pragma once

#include "sim.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace nf
{

class Injection
{
public:
    // Times count from tick `zero`. Faults before tick 0 begin there.
    Injection(const Config &config, double period_s, int64_t zero);

    // Before control() of each tick, which sees it. Call with ticks that rise. True: what lasts was
    // imposed anew.
    bool act(int64_t tick, Simulation &sim)
    {
        const bool due = tick >= next_;
        if (due) {
            change(tick, sim);
        }
        return due;
    }

    // A person breaks something: from this tick on, which has not acted yet, as long as such a
    // fault lasts.
    void begin(const FaultEntry &entry, int64_t tick);
    // What lasts of this kind is over from this tick on.
    void end(FaultKind kind, int64_t tick);

    // What it has put into the hardware binding.
    const hal_host_faults_t &binding() const
    {
        return binding_;
    }

private:
    static constexpr int64_t NEVER = std::numeric_limits<int64_t>::max();

    struct Fault {
        FaultEntry entry;
        int64_t from;
        int64_t until;
        bool begun;
        drive_in_t last;       // what the drive saw before it began …
        drive_out_t last_out;  // … and demanded
        uint32_t timer_counts; // of the machine
        uint16_t last_shaft;   // reading of the sensor
    };

    // What sensors read, of what they should.
    struct Sensors {
        std::array<double, PLANT_LEGS> current = {1, 1, 1};
        double bus = 1;
    };

    void add(const FaultEntry &entry, int64_t from, int64_t until);
    void change(int64_t tick, Simulation &sim);
    static void strike(const Fault &fault, const Seam &seam);
    void impose(int64_t tick, const Seam &seam);
    void impose_on_binding(const Fault &fault, hal_host_faults_t &hal) const;
    static void impose_on_shaft(const Fault &fault, hal_host_faults_t &hal);
    static void impose_on_plant(const Fault &fault, plant_t &plant, Sensors &sensors);
    static uint16_t duty_count(const Fault &fault, std::size_t leg);
    uint16_t current_count(double ampere) const;
    uint16_t bus_count(double volt) const;
    uint16_t count(double value) const;

    std::vector<Fault> faults_;
    int64_t next_ = NEVER; // tick at which one begins or ends
    hal_host_faults_t binding_{};
    BoardSettings board_;
};

} // namespace nf
