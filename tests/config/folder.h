/* SPDX-License-Identifier: MIT */
// A folder of small, valid files that a test can spoil one line at a time.
#pragma once

#include "config.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include <unistd.h>

namespace test
{

const std::map<std::string, std::string> VALID = {
    {"motors/m.toml", "[motor]\n"
                      "name = \"m\"\n"
                      "pole_pairs = 2\n"
                      "resistance_ohm = 2.125\n"
                      "inductance_d_h = 0.0116\n"
                      "inductance_q_h = 0.0116\n"
                      "flux_linkage_wb = 0.387\n"
                      "rated_torque_nm = 7.8\n"
                      "rated_speed_rpm = 1800\n"
                      "max_speed_rpm = 2000\n"
                      "max_current_a = 10\n"
                      "inertia_kg_m2 = 0.003\n"
                      "viscous_friction_nm_s = 0.001\n"},
    {"boards/b.toml", "[board]\n"
                      "name = \"b\"\n"
                      "pwm_frequency_hz = 10000\n"
                      "timer_clock_hz = 170000000\n"
                      "adc_bits = 12\n"
                      "current_full_scale_a = 20\n"
                      "bus_full_scale_v = 450\n"
                      "bus_nominal_v = 310\n"
                      "bus_min_v = 200\n"
                      "bus_max_v = 400\n"
                      "overcurrent_a = 18\n"
                      "offset_max_a = 1\n"
                      "duty_margin_pct = 5\n"
                      "offset_samples_log2 = 8\n"},
    {"tunings/t.toml", "tuning.name = \"t\"\n"
                       "observer = {kappa = 0.03, kappa_p = 0, momentum = 0}\n"
                       "current_loop.bandwidth_hz = 500\n"
                       "[speed_loop]\n"
                       "bandwidth_hz = 20\n"
                       "damping = 1\n"
                       "ramp_rpm_s = 10000\n"
                       "inertia_feed_forward = 1\n"
                       "slow_ticks = 10\n"
                       "[position_loop]\n"
                       "bandwidth_hz = 5\n"
                       "speed_rpm = 900\n"
                       "acceleration_rad_s2 = 800\n"
                       "softness_s = 0.01\n"},
    {"imperfections/warm.toml", "[plant]\n"
                                "resistance_scale = 1.1\n"
                                "flux_scale = 0.99\n"},
    {"imperfections/hot.toml", "include = [\"warm\"]\n"
                               "[plant]\n"
                               "resistance_scale = 1.3\n"},
    {"scenarios/s.toml",
     "motor = \"m\"\n"
     "board = \"b\"\n"
     "tuning = \"t\"\n"
     "[scenario]\n"
     "title = \"a step\"\n"
     "mode = \"speed\"\n"
     "duration_s = 1\n"
     "command = [{time_s = -0.1, speed_rpm = 0}, {time_s = 0.2, speed_rpm = 1000}]\n"
     "[accept.ideal]\n"
     "speed_error_max_rpm = 5\n"
     "locked = true\n"
     "[accept.any]\n"
     "speed_error_max_rpm = 50\n"},
};

// The valid files in a folder of their own, which is the data folder and the working folder while
// this lives, so messages name the files as "motors/m.toml".
class Folder
{
public:
    Folder() : before_(std::filesystem::current_path())
    {
        std::string name = (std::filesystem::temp_directory_path() / "nfconfigXXXXXX").string();
        path_ = mkdtemp(name.data());
        for (const auto &[file, text] : VALID) {
            write(file, text);
        }
        std::filesystem::current_path(path_);
        setenv("NEUROFOC_DATA", path_.c_str(), 1);
    }

    Folder(const Folder &) = delete;
    Folder &operator=(const Folder &) = delete;

    ~Folder()
    {
        unsetenv("NEUROFOC_DATA");
        std::filesystem::current_path(before_);
        std::filesystem::remove_all(path_);
    }

    void write(const std::string &file, const std::string &text) const
    {
        std::filesystem::create_directories((path_ / file).parent_path());
        std::ofstream(path_ / file, std::ios::binary) << text;
    }

    // Replaces `old` in a valid file; with an empty `old`, appends.
    void edit(const std::string &file, const std::string &old, const std::string &text) const
    {
        std::string whole = VALID.at(file);
        const std::size_t at = old.empty() ? whole.size() : whole.find(old);
        write(file, whole.replace(at, old.size(), text));
    }

    const std::filesystem::path &path() const
    {
        return path_;
    }

private:
    std::filesystem::path before_;
    std::filesystem::path path_;
};

// The message with which scenario `s` is refused, or "accepted".
inline std::string refusal(const std::vector<std::string> &with = {},
                           const std::vector<std::string> &set = {})
{
    try {
        nf::build(nf::load_scenario("s", with, set));
    } catch (const nf::ConfigError &error) {
        return error.what();
    }
    return "accepted";
}

} // namespace test
