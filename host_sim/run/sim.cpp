// SPDX-License-Identifier: MIT
#include "sim.h"

#include "machine.h"
#include "numbers.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace nf
{
namespace
{

constexpr double Q16 = 65536.0;

// A command of the user as the drive's integer; what it cannot hold is as far as it goes.
int32_t to_target(double value)
{
    return static_cast<int32_t>(std::clamp(std::round(value), -2147483647.0, 2147483647.0));
}

} // namespace

Simulation::Simulation(const Config &config) : Simulation(config, config)
{
}

Simulation::Simulation(const Config &real, const Config &believed)
    : cfgs_{build(believed)}, bases_(make_bases(believed.motor, believed.board))
{
    const plant_cfg_t plant_cfg = make_plant_cfg(real, cfgs_[0]);
    const char *bad = nullptr;
    if (!plant_init(&plant_, &plant_cfg, &bad)) {
        throw ConfigError(fmt::format("the simulated hardware cannot have this {}", bad));
    }
    hal_host_init(&hal_, &plant_);
    start(cfgs_[0]);
}

Simulation::Simulation(const DriveImage &image) : cfgs_{image.cfg}, bases_(image.bases)
{
    hal_host_init(&hal_, nullptr);
    start(cfgs_[0]);
    app_.drive = image.state;
    app_.drive.cfg = cfgs_.data();
}

void Simulation::start(const drive_cfg_t &cfg)
{
    if (const char *const bad = app_init(&app_, &hal_, &cfg)) {
        throw ConfigError(fmt::format("the drive refuses its setting {}", bad));
    }
    if (hal_.plant != nullptr) { // else the frames have the angle
        app_sense(&app_, &shaft_);
    }
}

void Simulation::restore(const State &state)
{
    cfgs_ = state.cfgs;
    plant_ = state.plant;
    hal_ = state.hal;
    app_ = state.app;
    shaft_ = state.shaft;
    bases_ = rescaled(bases_, cfg());
}

void Simulation::change(const drive_cfg_t &cfg)
{
    drive_cfg_t &other = cfgs_[1 - in_force()];
    other = cfg;
    drive_change(&app_.drive, &other);
    bases_ = rescaled(bases_, other);
}

void Simulation::command(drive_mode_t mode, double target)
{
    drive_command_t whole = command_mailbox_take(&app_.mailbox);
    whole.mode = mode;
    whole.target = to_target(target);
    command_mailbox_post(&app_.mailbox, &whole);
}

void Simulation::command_speed_rpm(double rpm)
{
    command(DRIVE_MODE_SPEED, bases_.step_from_rpm(rpm));
}

void Simulation::command_position_rad(double mech_rad)
{
    command(DRIVE_MODE_POSITION, bases_.turns_from_mech_rad(mech_rad) * Q16);
}

void Simulation::command_torque_nm(double torque_nm)
{
    command(DRIVE_MODE_TORQUE, torque_nm / bases_.torque_nm() * Q28);
}

void Simulation::set_load_nm(double torque_nm)
{
    plant_set_load_torque(&plant_, torque_nm);
}

} // namespace nf
