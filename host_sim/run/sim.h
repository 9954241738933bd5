/* SPDX-License-Identifier: MIT */
// One motor, one inverter and one drive, coupled through the host's hardware binding.
//
// A tick is control(), then advance(). Before control() of tick k the drive holds what it believes
// about t_k (its speed and angle estimate for this instant), and the plant is what is true at t_k.
#pragma once

#include "config.h"
#include "recorded_run.h"

extern "C" {
#include "app.h"
#include "cross_check.h"
#include "hal_host.h"
#include "plant.h"
}

#include <array>

namespace nf
{

// Where faults get at a simulation.
struct Seam {
    plant_t &plant;
    hal_host_faults_t &hal;
    drive_cfg_t &cfg; // the one that the drive works with
    drive_t &drive;
};

class Simulation
{
public:
    // Throws ConfigError when the drive or the plant refuses the configuration.
    explicit Simulation(const Config &config);
    // The motor and the board of one configuration, and a drive that believes another one, of the
    // same board.
    Simulation(const Config &real, const Config &believed);
    // Without a motor: feed() says before each control() what is measured and wanted.
    explicit Simulation(const DriveImage &image);
    // The drive keeps a pointer to its configuration.
    Simulation(const Simulation &) = delete;
    Simulation &operator=(const Simulation &) = delete;

    // All that changes while it runs, as plain values. A copy is good for the simulation it is
    // from.
    struct State {
        std::array<drive_cfg_t, 2> cfgs;
        plant_t plant;
        hal_t hal;
        app_t app;
        shaft_decoder_t shaft;
    };
    State save() const
    {
        return {cfgs_, plant_, hal_, app_, shaft_};
    }
    void restore(const State &state);

    // The control interrupt of the present instant.
    void control()
    {
        control_isr(&app_);
    }

    // The drive takes over another configuration, as the control interrupt does it: before the next
    // control(), which computes with it. config_check() accepts it.
    void change(const drive_cfg_t &cfg);

    // Gives the power stage another demand than that of the last control().
    void apply(const drive_out_t &out)
    {
        hal_apply(&hal_, &out);
    }

    // One PWM period goes by.
    void advance()
    {
        if (hal_.plant != nullptr) { // else its frames have what the background found
            cross_check_step(&app_);
        }
        hal_host_step(&hal_);
    }

    // The next frame of a drive without a motor. Its command is in force already.
    void feed(const drive_in_t &in)
    {
        hal_host_feed(&hal_, &in);
        app_.in.command = in.command;
        command_mailbox_post(&app_.mailbox, &in.command);
    }

    // Requests of the user, from the next control() on.
    void request(uint8_t drive_request)
    {
        drive_command_t command = command_mailbox_take(&app_.mailbox);
        command.request = drive_request;
        command_mailbox_post(&app_.mailbox, &command);
    }
    void command_speed_rpm(double rpm);
    void command_position_rad(double mech_rad);
    void command_torque_nm(double torque_nm);
    // From the present instant.
    void set_load_nm(double torque_nm);

    Seam seam()
    {
        return {plant_, hal_.faults, const_cast<drive_cfg_t &>(cfg()), app_.drive};
    }

    // For the background that runs on it.
    app_t &app()
    {
        return app_;
    }
    hal_t &hal()
    {
        return hal_;
    }
    const hal_t &hal() const
    {
        return hal_;
    }

    // Begins anew with another configuration, which outlives the simulation where it is; the
    // background may put another one in its place. Throws ConfigError when the drive refuses it.
    // What it is then cannot be saved.
    void start(const drive_cfg_t &cfg);

    const drive_t &drive() const
    {
        return app_.drive;
    }
    // The frames of the last control().
    const drive_in_t &in() const
    {
        return app_.in;
    }
    const drive_out_t &out() const
    {
        return app_.out;
    }
    // In force; a change puts the next one elsewhere, and this one stays until the change after it.
    const drive_cfg_t &cfg() const
    {
        return *app_.drive.cfg;
    }
    const Bases &bases() const
    {
        return bases_;
    }
    // The decoder of the shaft's sensor.
    const shaft_decoder_t &shaft() const
    {
        return shaft_;
    }
    const plant_t &plant() const
    {
        return plant_;
    }

private:
    void command(drive_mode_t mode, double target);
    std::size_t in_force() const
    {
        return app_.drive.cfg == &cfgs_[1] ? 1 : 0;
    }

    std::array<drive_cfg_t, 2> cfgs_; // take turns
    Bases bases_;
    plant_t plant_{};
    hal_t hal_{};
    app_t app_{};
    shaft_decoder_t shaft_{};
};

} // namespace nf
