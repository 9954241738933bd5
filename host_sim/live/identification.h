/* SPDX-License-Identifier: MIT */
// A measurement of a board's motor, from its first line to the motor file.
#pragma once

#include "config.h"
#include "evaluate.h"
#include "measurement.h"

#include <string>

namespace nf::live
{

struct MeasuredMotor {
    identify::Result result;
    double duration_s = 0;

    // The text of its motor file. Throws ConfigError.
    std::string file_text() const;
};

class Identification
{
public:
    // Of a motor of which so much is known. It begins at this time of the board.
    Identification(Config known, double begins_s);

    // A line of the console, as Measurement::take().
    bool take(const std::string &line)
    {
        return measurement_.take(line);
    }

    void stop()
    {
        measurement_.stop();
    }

    // Well or not. A board whose last line is lost ends it by itself by then, too.
    bool has_ended(double now_s) const;

    double begun_s() const
    {
        return begun_s_;
    }
    const Measurement &measurement() const
    {
        return measurement_;
    }

    // What was found. Throws ConfigError: why nothing is.
    MeasuredMotor found() const;

private:
    Config known_;
    double begun_s_;
    Measurement measurement_;
};

} // namespace nf::live
