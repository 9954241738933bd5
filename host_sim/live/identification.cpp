// SPDX-License-Identifier: MIT
#include "identification.h"

#include "measured_file.h"

#include <utility>

#include <fmt/format.h>

namespace nf::live
{
namespace
{

constexpr double LONGEST_S = 130; // the drive ends it by itself within 2 minutes
constexpr double WINDING_C = 25;  // of which nobody knows more

std::string reason(const Measurement &measurement)
{
    return measurement.has_ended() ? measurement.refusal()
                                   : "its end did not come; `stop` ends it on the board";
}

} // namespace

std::string MeasuredMotor::file_text() const
{
    return measured_motor_file(
        result.motor, result.measured,
        fmt::format("Measured by the drive in {:.0f} s, at its line.", duration_s));
}

Identification::Identification(Config known, double begins_s)
    : known_(std::move(known)), begun_s_(begins_s)
{
}

bool Identification::has_ended(double now_s) const
{
    return measurement_.has_ended() || now_s > begun_s_ + LONGEST_S;
}

MeasuredMotor Identification::found() const
{
    if (const std::string why = reason(measurement_); !why.empty()) {
        throw ConfigError("identify: " + why);
    }
    const identify::Records records = identify::read_records(measurement_.lines(), "the console");
    return {identify::evaluate(records, known_, WINDING_C), records.duration_s};
}

} // namespace nf::live
