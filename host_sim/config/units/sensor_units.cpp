// SPDX-License-Identifier: MIT
#include "sensor_units.h"

#include "numbers.h"

#include <cmath>

namespace nf
{
namespace
{

constexpr int COUNTS_PER_LINE = 4;
constexpr double Q16 = 65536;
constexpr double DEG_PER_TURN = 360;
constexpr double HALL_ABOVE_PCT = 30; // there the observer is better than edges 60° apart
constexpr double BELOW_SHARE = 0.75;
constexpr double MANY_PCT = 100;

uint32_t angle_q16(double deg)
{
    const double turns = deg / DEG_PER_TURN;
    return static_cast<uint32_t>(std::lround((turns - std::floor(turns)) * Q16)) & 0xFFFFU;
}

void set_hall(hall_cfg_t &c, const SensorSettings &sensor)
{
    c.patterns = hall_patterns(sensor);
    for (std::size_t k = 0; k < HALL_SECTORS; k++) {
        c.edges_q16[k] = angle_q16(sensor.hall_edges_deg.at(k));
    }
}

// With all the torque of the motor against it, and as much of a load, a rotor of this speed stops
// within a sector: ω² = 2·α·π/3. Four times that torque is left for an inertia that is less than
// the file's.
constexpr double STOPPING = 4;
constexpr double SECTOR_RAD = PI / 3;

step_t fast_speed(const MotorSettings &motor, const Bases &b)
{
    const double torque = 1.5 * motor.pole_pairs * motor.flux_linkage_wb * motor.max_current_a;
    const double slowing = STOPPING * 2 * torque / motor.inertia_kg_m2 * motor.pole_pairs;
    const double speed = std::sqrt(2 * slowing * SECTOR_RAD);
    const double step = speed / TWO_PI * b.control_period_s * STEPS_PER_TURN;
    return static_cast<step_t>(std::clamp(step, 1.0, std::ldexp(1.0, 29)));
}

bool counts(SensorKind kind)
{
    return kind == SensorKind::encoder || kind == SensorKind::encoder_index;
}

// A sensor that is not used does not run either.
SensorKind kind_in_use(const MotorSettings &motor, const TuningSettings &tuning)
{
    return tuning.angle_source == AngleSource::observer ? SensorKind::none : motor.sensor.kind;
}

// An encoder finds its zero by the alignment of a start-up.
void check_alignment(SensorKind kind, const TuningSettings &tuning)
{
    if (counts(kind)) {
        require({"startup.current_pct", tuning.startup_current_pct}, 1, HUGE_VAL,
                "an encoder has to be aligned at the start, which takes drive.angle_source = "
                "\"both\" and an imposed current");
    }
}

// Below the hand-over speed only an imposed current holds a motor whose sensor has failed.
void check_fail_over(const TuningSettings &tuning)
{
    if (tuning.angle_source == AngleSource::both) {
        require({"startup.current_pct", tuning.startup_current_pct}, 1, HUGE_VAL,
                "with drive.angle_source = \"both\" a current is imposed at low speed when the "
                "sensor fails");
    }
}

} // namespace

uint32_t hall_patterns(const SensorSettings &sensor)
{
    uint32_t patterns = 0;
    for (std::size_t k = 0; k < HALL_SECTORS; k++) {
        patterns |= static_cast<uint32_t>(sensor.hall_patterns.at(k)) << (3 * k);
    }
    return patterns;
}

SensorSpan sensor_span(const MotorSettings &motor, const TuningSettings &tuning)
{
    SensorSpan span{0, 0};
    if (tuning.angle_source == AngleSource::both) {
        const double by_kind = motor.sensor.kind == SensorKind::hall ? HALL_ABOVE_PCT : 0;
        span.observer_above_pct =
            tuning.observer_above_pct < 0 ? by_kind : tuning.observer_above_pct;
        span.sensor_below_pct = tuning.sensor_below_pct < 0 ? BELOW_SHARE * span.observer_above_pct
                                                            : tuning.sensor_below_pct;
    }
    return span;
}

sensor_cfg_t make_sensor(const MotorSettings &motor, const TuningSettings &tuning, const Bases &b)
{
    const SensorSettings &sensor = motor.sensor;
    const SensorKind kind = kind_in_use(motor, tuning);
    sensor_cfg_t c{};
    check_alignment(kind, tuning);
    check_fail_over(tuning);
    c.kind = static_cast<uint32_t>(kind);
    set_hall(c.hall, sensor);
    c.hall.fast_speed = fast_speed(motor, b);
    c.encoder.counts = sensor.lines * COUNTS_PER_LINE;
    c.encoder.scale_q32 = static_cast<uint32_t>(std::floor(STEPS_PER_TURN / c.encoder.counts));
    c.encoder.reversed = sensor.reversed ? 1 : 0;
    c.encoder.has_index = kind == SensorKind::encoder_index ? 1 : 0;
    c.absolute.zero = angle_q16(sensor.offset_deg);
    c.absolute.reversed = c.encoder.reversed;
    const SensorSpan span = sensor_span(motor, tuning);
    const double rated = b.step_from_rpm(motor.rated_speed_rpm);
    require({"drive.sensor_below_pct", span.sensor_below_pct}, 0, span.observer_above_pct,
            "no more than drive.observer_above_pct");
    store(c.observer_above, rated * span.observer_above_pct / MANY_PCT, 0, 1 << 29,
          {"drive.observer_above_pct", span.observer_above_pct}, "the firmware's steps of speed");
    store(c.sensor_below, rated * span.sensor_below_pct / MANY_PCT, 0, 1 << 29,
          {"drive.sensor_below_pct", span.sensor_below_pct}, "the firmware's steps of speed");
    return c;
}

} // namespace nf
