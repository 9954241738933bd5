// SPDX-License-Identifier: MIT
#include "nn_observer_units.h"

#include "model_units.h"
#include "numbers.h"

#include <algorithm>
#include <cmath>

namespace nf
{
namespace
{

// Bits that b loses: as many as leave room for the largest error, fewer where the states are small
// and the gains large.
constexpr int GRADIENT_SHIFT_MAX = 12;
constexpr int GRADIENT_SHIFT_MIN = 4;

// The base of the observer's states, I_x = 2^s·I_b: both states fit for every current that the
// over-current protection lets through (three phases within it make a vector of 2/√3 of it). Not
// larger than that, for the adaptation's gains per unit grow with it.
int observer_shift(const MotorSettings &motor, const BoardSettings &board,
                   const ModelHeadroom &headroom, const Model &m, const Bases &b)
{
    constexpr double largest_base = 1 << 9;
    const double current = 2 / std::sqrt(3.0) * board.overcurrent_a / b.current_a;
    const double flux = headroom.flux * m.flux_current / b.current_a;
    const double x = current + flux;
    const double y = current * headroom.saliency * m.inductance_q / m.inductance_d;
    require(flux, 0, largest_base - 1, {"motor.flux_linkage_wb", motor.flux_linkage_wb},
            "φ/L_d below 511 times twice board.current_full_scale_a");
    require(y, 0, largest_base, {"motor.inductance_q_h", motor.inductance_q_h},
            "L_q/L_d within the observer's base");
    int shift = 0;
    while (std::ldexp(1.0, shift) <= std::max(x, y)) {
        shift++;
    }
    return shift;
}

// D: what an error of the network loses in a period.
double error_decay(const TuningSettings &tuning, const Model &m, const Bases &b)
{
    return b.control_period_s * m.resistance / m.inductance_d + tuning.observer_feedback;
}

// D, W3, f/D and the shift of (7). A faster PWM makes the winding's decay and W3 smaller.
void set_network(nn_observer_cfg_t &c, const MotorSettings &motor, const BoardSettings &board,
                 const TuningSettings &tuning, const ModelHeadroom &headroom, const Model &m,
                 const Bases &b)
{
    const double period = b.control_period_s;
    const double base_x = std::ldexp(b.current_a, static_cast<int>(c.current_shift));
    const double decay = error_decay(tuning, m, b) * b.current_a / base_x;
    const double volt_gain = period / m.inductance_d * b.voltage_v / base_x;
    const Source frequency = {"board.pwm_frequency_hz", board.pwm_frequency_hz, -1};
    const Mantissa largest =
        normalise(std::ldexp(headroom.weight * std::max(decay, volt_gain), 12), 2, 15, frequency,
                  "the current of this motor changes too much in a PWM period");
    c.weight_shift = largest.shift;
    const double weight = std::ldexp(1.0, 12 + static_cast<int>(largest.shift));
    c.decay = static_cast<int32_t>(std::lround(decay * weight));
    c.volt_gain = static_cast<int32_t>(std::lround(volt_gain * weight));
    // As whole units of the decay: the model in force takes them apart again,
    // firmware/control/model.c.
    const double feedback = std::round(tuning.observer_feedback * b.current_a / base_x * weight);
    keep(c.feedback_q15, feedback / std::max(c.decay, 1) * Q15, 0, MANTISSA_MAX);
    store(c.flux_q27, m.flux_current / base_x * Q27, 1, Q27 - 1,
          {"motor.flux_linkage_wb", motor.flux_linkage_wb}, "φ/L_d in the observer's numbers");
    store(c.iq_gain_q14, m.inductance_d / m.inductance_q * Q14, 1, MANTISSA_MAX,
          {"motor.inductance_d_h", motor.inductance_d_h}, "twice motor.inductance_q_h");
    store(c.saliency_q13, m.inductance_q / m.inductance_d * Q13, 1, MANTISSA_MAX,
          {"motor.inductance_q_h", motor.inductance_q_h}, "four times motor.inductance_d_h");
}

// A mantissa that can still grow by `headroom`, as far as there is room: the correction ends there.
Mantissa with_headroom(double number, double headroom, const Source &source, const char *what)
{
    const Mantissa full = normalise(number, 0, 30, source, what);
    const int shift = std::max(0, static_cast<int>(full.shift) -
                                      static_cast<int>(std::ceil(std::log2(headroom))));
    return {static_cast<int32_t>(std::lround(std::ldexp(number, shift))),
            static_cast<uint32_t>(shift)};
}

// κ, κ_p, α: (19)–(22), and the limit of ρ.
void set_adaptation(nn_observer_cfg_t &c, const TuningSettings &tuning, double headroom,
                    const Model &m, const Bases &b)
{
    const char *const reason =
        "more is beyond the observer's numbers, for φ/L_d is small against the current range; a "
        "board with a smaller board.current_full_scale_a allows more";
    const double base_x = std::ldexp(b.current_a, static_cast<int>(c.current_shift));
    // b(k) is a product in Q15 of I_b times Q15 of I_x; 4/2π turns radians in Q30 into steps.
    const double steps = b.current_a * base_x / (m.flux_current * m.flux_current) * 4.0 / TWO_PI;
    const double eta_steps = tuning.observer_kappa * (1.0 - tuning.observer_momentum) * steps;
    const double kappa_p_steps = tuning.observer_kappa_p * steps;
    int shift = GRADIENT_SHIFT_MAX;
    while (shift > GRADIENT_SHIFT_MIN &&
           std::ldexp(headroom * std::max(eta_steps, kappa_p_steps), shift) > MANTISSA_MAX) {
        shift--;
    }
    c.gradient_shift = static_cast<uint32_t>(shift);
    const Mantissa eta = with_headroom(std::ldexp(eta_steps, shift), headroom,
                                       {"observer.kappa", tuning.observer_kappa}, reason);
    c.eta = eta.value;
    c.eta_shift = eta.shift;
    const Mantissa kappa_p = with_headroom(std::ldexp(kappa_p_steps, shift), headroom,
                                           {"observer.kappa_p", tuning.observer_kappa_p}, reason);
    c.kappa_p = kappa_p.value;
    c.kappa_p_shift = kappa_p.shift;
    c.momentum_q15 = static_cast<int32_t>(std::lround(tuning.observer_momentum * Q15));
    c.frame_share_q13 = static_cast<int32_t>(std::lround(tuning.observer_frame_share * Q13));
    const double corner = error_decay(tuning, m, b) / TWO_PI;
    c.corner = static_cast<step_t>(std::lround(std::min(corner * STEPS_PER_TURN, Q27)));
    c.rho_max_q13 = static_cast<int32_t>(std::lround(tuning.observer_rho_max * Q13));
}

} // namespace

nn_observer_cfg_t make_observer(const MotorSettings &motor, const BoardSettings &board,
                                const TuningSettings &tuning, const Model &m, const Bases &b)
{
    const ModelHeadroom headroom = model_headroom(tuning);
    nn_observer_cfg_t c{};
    c.current_shift = static_cast<uint32_t>(observer_shift(motor, board, headroom, m, b));
    set_network(c, motor, board, tuning, headroom, m, b);
    set_adaptation(c, tuning, headroom.rate, m, b);
    c.speed_limit = b.speed_limit;
    const double slowest_pct =
        tuning.loaded_speed_pct > 0 ? tuning.loaded_speed_pct : tuning.handover_speed_pct;
    keep(c.rho_speed_min, b.step_from_rpm(motor.rated_speed_rpm) * slowest_pct / 200, 1, Q30 / 2);
    return c;
}

double estimate_lag_s(const TuningSettings &tuning, double period_s)
{
    const bool is_observed = tuning.angle_source == AngleSource::observer;
    return is_observed && tuning.observer_kappa > 0
               ? tuning.observer_kappa_p / tuning.observer_kappa * period_s
               : 0;
}

} // namespace nf
