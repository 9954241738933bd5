#include "scenario.h"

#include "injection.h"
#include "operator.h"
#include "profile.h"

#include <cmath>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr double RPM_PER_RAD_S = 30.0 / 3.14159265358979323846;
constexpr double Q15 = 32768.0;
constexpr int64_t PROGRESS_TICKS = 1 << 14;

std::vector<TimedValue> scaled(std::vector<TimedValue> steps, double factor)
{
    for (TimedValue &step : steps) {
        step.value *= factor;
    }
    return steps;
}

std::vector<Parameter> parameters_of(const Config &config, const drive_t &drive)
{
    constexpr double ratio_q14 = 1.0 / MODEL_RATIO_ONE;
    const MotorSettings &motor = config.motor;
    const auto parameter = [](const char *name, double nameplate, double belief, double ratio,
                              double real) {
        return Parameter{name, nameplate * belief, nameplate * belief * ratio, nameplate * real};
    };
    return {
        parameter("resistance_ohm", motor.resistance_ohm, config.model.resistance,
                  drive.model.resistance_q14 * ratio_q14, config.plant.resistance_scale),
        parameter("inductance_d_h", motor.inductance_d_h, config.model.inductance,
                  drive.model.inductance_q14 * ratio_q14, config.plant.inductance_scale),
        parameter("flux_linkage_wb", motor.flux_linkage_wb, config.model.flux,
                  std::ldexp(drive.model.flux_q30, -30), config.plant.flux_scale),
    };
}

class Run
{
public:
    Run(const Config &config, const RunOptions &options);
    RunResult all();

private:
    int64_t ticks_in(double seconds) const
    {
        return std::llround(seconds / sim_.bases().control_period_s);
    }
    void drive_profiles();
    void send_command();
    void one();
    void evaluate(const Tick &tick);
    void watch_state();
    bool reference_moving();

    const Config &config_;
    const ScenarioSettings &scenario_;
    const RunOptions &options_;
    Simulation sim_;
    int64_t zero_; // tick of t = 0
    int64_t evaluate_from_;
    int64_t end_;
    Profile command_;
    Profile load_;
    Injection injection_;
    Operator operator_;
    Metrics metrics_;
    double rpm_per_step_;
    double ampere_per_bit_;
    int64_t tick_ = 0;
    int64_t reference_ = 0;
    drive_state_t state_ = DRIVE_STATE_INIT;
    RunResult result_;
};

Run::Run(const Config &config, const RunOptions &options)
    : config_(config), scenario_(config.scenario), options_(options), sim_(config),
      zero_(ticks_in(scenario_.prelude_s)),
      evaluate_from_(zero_ + ticks_in(scenario_.evaluate_from_s)),
      end_(zero_ + ticks_in(scenario_.duration_s)),
      command_(scenario_.command, sim_.bases().control_period_s, zero_),
      load_(scaled(scenario_.load, scenario_.load_scale), sim_.bases().control_period_s, zero_),
      injection_(config, sim_.bases().control_period_s, zero_),
      operator_(scenario_.requests, sim_.bases().control_period_s, zero_),
      metrics_(scenario_.mode, sim_.bases().control_period_s, config.motor.rated_speed_rpm),
      rpm_per_step_(sim_.bases().rpm_from_step(1)), ampere_per_bit_(sim_.bases().current_a / Q15)
{
    send_command();
}

void Run::send_command()
{
    if (scenario_.mode == DriveMode::position) {
        sim_.command_position_rad(command_.value());
    } else {
        sim_.command_speed_rpm(command_.value());
    }
}

void Run::drive_profiles()
{
    const bool evaluated = tick_ >= evaluate_from_;
    if (command_.advance(tick_)) {
        send_command();
        if (evaluated) {
            metrics_.command_step(command_.value());
        } else {
            metrics_.start(command_.value());
        }
    }
    if (load_.advance(tick_)) {
        sim_.set_load_nm(load_.value());
        if (evaluated) {
            metrics_.load_step();
        }
    }
}

// The speed ramp, or the position profile.
bool Run::reference_moving()
{
    const drive_t &drive = sim_.drive();
    const int64_t reference = scenario_.mode == DriveMode::position
                                  ? drive.position_loop.profile_q32
                                  : int64_t{drive.speed_reference};
    const bool moving = reference != reference_;
    reference_ = reference;
    return moving;
}

void Run::evaluate(const Tick &tick)
{
    const drive_t &drive = sim_.drive();
    const plant_view_t &truth = tick.truth;
    Instant now{};
    now.speed_rpm = truth.omega_mech_rad_s * RPM_PER_RAD_S;
    now.speed_estimated_rpm = tick.speed_estimate * rpm_per_step_;
    now.angle_error_deg = angle_error_deg(tick);
    now.iq_error_a = truth.i_q_a - drive.observer.current.q * ampere_per_bit_;
    now.i_d_a = truth.i_d_a;
    now.actual = tick.mode == DriveMode::position ? truth.theta_mech_rad : now.speed_rpm;
    now.running = drive.state > DRIVE_STATE_READY && drive.state < DRIVE_STATE_FAULT;
    now.reference_moving = reference_moving();
    metrics_.add(now);
    if (now.running) {
        result_.saturations.add(drive, sim_.out());
    }
}

void Run::watch_state()
{
    const drive_state_t state = sim_.drive().state;
    if (state == state_) {
        return;
    }
    if (state == DRIVE_STATE_FAULT) {
        result_.faults.push_back(sim_.drive().fault);
    }
    state_ = state;
}

void Run::one()
{
    drive_profiles();
    injection_.act(tick_, sim_);
    operator_.act(tick_, sim_);
    Tick tick{};
    tick.sim = &sim_;
    tick.speed_estimate = drive_speed(&sim_.drive());
    tick.position_estimate_q32 = drive_position_q32(&sim_.drive());
    plant_view(&sim_.plant(), &tick.truth);
    tick.time_s = static_cast<double>(tick_ - zero_) * sim_.bases().control_period_s;
    tick.mode = scenario_.mode;
    tick.command = command_.value();
    tick.load_nm = load_.value();
    sim_.control();
    watch_state();
    if (tick_ >= evaluate_from_) {
        evaluate(tick);
    }
    if (options_.sink != nullptr) {
        options_.sink->add(tick);
    }
    if (options_.power_stage) {
        sim_.apply(options_.power_stage(tick));
    }
    sim_.advance();
}

RunResult Run::all()
{
    for (tick_ = 0; tick_ < end_; tick_++) {
        one();
        if (options_.progress && tick_ % PROGRESS_TICKS == 0) {
            options_.progress(static_cast<double>(tick_) / static_cast<double>(end_));
        }
    }
    if (options_.progress) {
        options_.progress(1.0);
    }
    result_.parameters = parameters_of(config_, sim_.drive());
    result_.metrics = metrics_.finish();
    result_.ticks = end_;
    result_.state_final = sim_.drive().state;
    result_.gates_enabled_final = sim_.plant().gates_on;
    return result_;
}

} // namespace

RunResult run_scenario(const Config &config, const RunOptions &options)
{
    return Run(config, options).all();
}

std::optional<double> figure(const RunResult &result, const std::string &metric)
{
    for (const MetricField &field : metric_fields()) {
        if (metric == field.name) {
            return result.metrics.*field.value;
        }
    }
    if (metric == SATURATION_INTERNAL_COUNT) {
        return static_cast<double>(result.saturations.internal_count());
    }
    return std::nullopt;
}

std::string Violation::text() const
{
    return fmt::format("{} = {}, limit: {}", metric, value.empty() ? "none" : value, limit);
}

const AcceptLimits *limits_of(const Config &config)
{
    return config.scenario.limits(selection_name(config.sources.imperfections));
}

std::vector<Violation> violations(const Config &config, const RunResult &result)
{
    std::vector<Violation> found;
    const AcceptLimits *limits = limits_of(config);
    if (limits == nullptr) {
        return found;
    }
    if (limits->must_lock && !result.metrics.locked) {
        found.push_back({"locked", "false", "true"});
    }
    for (const auto &[metric, limit] : limits->upper) {
        const std::optional<double> value = figure(result, metric);
        const bool holds = value && *value <= limit;
        if (!holds) {
            found.push_back(
                {metric, value ? fmt::format("{:.4g}", *value) : "", fmt::format("{:g}", limit)});
        }
    }
    return found;
}

} // namespace nf
