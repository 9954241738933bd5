// SPDX-License-Identifier: MIT
#include "replace.h"

#include "si.h"

extern "C" {
#include "estimate.h"
}

#include <cmath>
#include <cstdlib>

namespace nf::peers
{
namespace
{

constexpr double STEPS_PER_RAD = 4294967296.0 / TWO_PI;
constexpr double Q15 = 32768.0;
constexpr double Q14 = 16384.0;
constexpr double Q30 = 1073741824.0;

class Replacement
{
public:
    Replacement(const Config &config, std::unique_ptr<Estimator> estimator)
        : motor_(config.motor), belief_(config.model),
          bases_(make_bases(config.motor, config.board)), estimator_(std::move(estimator))
    {
    }

    void act(drive_t &drive, const sample_t &sample);

private:
    Model model(const drive_t &drive) const;
    Complex current(const sample_t &sample) const;
    Complex voltage(const drive_t &drive) const;
    double course(const drive_t &drive) const;
    Estimate known(const drive_t &drive) const;
    void tell(drive_t &drive, const Estimate &estimate) const;

    MotorSettings motor_;
    ModelScales belief_;
    Bases bases_;
    std::unique_ptr<Estimator> estimator_;
    // The drive's, at the end of the last tick: they make the voltage that acts until this one's
    // samples.
    ab_t ratio_{};
    int32_t bus_ = 0;
    bool started_ = false;
};

double speed_of(const Bases &bases, double step)
{
    return step / STEPS_PER_RAD / bases.control_period_s;
}

// Without its adaptation the network leaves the speed as it is told. The check word goes with it:
// this is no flipped bit.
void stop_training(drive_t &drive)
{
    nn_observer_cfg_t &network = drive.motor.model.observer;
    drive.motor.model.check_gains ^= static_cast<uint32_t>(network.eta ^ network.kappa_p);
    network.eta = 0;
    network.kappa_p = 0;
}

Model Replacement::model(const drive_t &drive) const
{
    const double inductance = belief_.inductance * drive.motor.model.inductance_q14 / Q14;
    return {bases_.control_period_s,
            motor_.resistance_ohm * belief_.resistance * drive.motor.model.resistance_q14 / Q14,
            motor_.inductance_d_h * inductance,
            motor_.inductance_q_h * inductance * drive.motor.model.saliency_q14 / Q14,
            motor_.flux_linkage_wb * belief_.flux * drive.motor.model.flux_q30 / Q30,
            speed_of(bases_, drive.cfg->observer.rho_speed_min),
            speed_of(bases_, drive.cfg->observer.speed_limit)};
}

// Clarke's transformation of two phases.
Complex Replacement::current(const sample_t &sample) const
{
    const double a = sample.phase_a;
    const double b = sample.phase_b;
    return Complex(a, (a + 2 * b) / std::sqrt(3.0)) * (bases_.current_a / Q15);
}

Complex Replacement::voltage(const drive_t &drive) const
{
    const double bus_v = (bus_ + drive.bus) / 2.0 * bases_.voltage_v / Q15;
    return Complex(ratio_.alpha, ratio_.beta) * (bus_v / Q15);
}

// As the drive's observer has it for the sign of its ρ.
double Replacement::course(const drive_t &drive) const
{
    const bool fast = std::abs(drive.rotor.observer.speed) >= 2 * drive.cfg->startup.handover_speed;
    return speed_of(bases_, fast ? drive.rotor.observer.speed : drive.motion.speed_loop.reference);
}

Estimate Replacement::known(const drive_t &drive) const
{
    return {rotor_position_angle(&drive.rotor.position) / STEPS_PER_RAD,
            speed_of(bases_, drive.rotor.observer.speed)};
}

// The position is a count of turns: it moves to the nearest place of that angle.
void Replacement::tell(drive_t &drive, const Estimate &estimate) const
{
    if (!std::isfinite(estimate.angle_rad) || !std::isfinite(estimate.speed_rad_s)) {
        return; // it has diverged, and the drive goes on as it last knew
    }
    const double step = estimate.speed_rad_s * bases_.control_period_s * STEPS_PER_RAD;
    const auto wanted = static_cast<uint64_t>(std::llround(estimate.angle_rad * STEPS_PER_RAD));
    const auto ahead =
        static_cast<angle_t>(wanted & 0xFFFFFFFFU) - rotor_position_angle(&drive.rotor.position);
    rotor_position_step(&drive.rotor.position, static_cast<int32_t>(ahead));
    nn_observer_follow(&drive.rotor.observer, static_cast<step_t>(std::lround(step)));
}

void Replacement::act(drive_t &drive, const sample_t &sample)
{
    stop_training(drive);
    if (!drive_is_controlled(drive.state)) {
        started_ = false;
    } else if (!started_) {
        estimator_->start(model(drive), known(drive), current(sample));
        started_ = true;
    } else {
        const Estimate estimate =
            estimator_->step(model(drive), {current(sample), voltage(drive), course(drive)});
        if (estimate_is_trained(&drive)) {
            tell(drive, estimate);
        } else {
            estimator_->follow(model(drive), known(drive));
        }
    }
    ratio_ = drive.control.ratio_acting;
    bus_ = drive.bus;
}

} // namespace

std::function<void(drive_t &, const sample_t &)>
in_place_of_the_observer(const Config &config, std::unique_ptr<Estimator> estimator)
{
    if (config.tuning.angle_source == AngleSource::sensor) {
        fail({"--estimator"}, "drive.angle_source", "\"sensor\"", "leaves nothing to estimate",
             "\"observer\"");
    }
    return [replacement = std::make_shared<Replacement>(config, std::move(estimator))](
               drive_t &drive, const sample_t &sample) { replacement->act(drive, sample); };
}

} // namespace nf::peers
