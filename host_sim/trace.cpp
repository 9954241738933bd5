#include "trace.h"

#include "names.h"

extern "C" {
#include "fault_text.h"
}

#include <cerrno>
#include <cstring>
#include <iterator>

#include <fmt/compile.h>

namespace nf
{
namespace
{

constexpr std::size_t FLUSH_BYTES = 1U << 18U;
constexpr double Q15 = 32768.0;
constexpr double Q32 = 4294967296.0;
constexpr double PI = 3.14159265358979323846;
constexpr double RPM_PER_RAD_S = 30.0 / PI;
constexpr double DEG_PER_RAD = 180.0 / PI;
constexpr double DEG_PER_STEP = 360.0 / Q32;

constexpr const char *HEADER =
    "time_s,state,speed_command_rpm,speed_rpm,speed_estimated_rpm,speed_reference_rpm,"
    "position_command_rad,position_rad,position_estimated_rad,"
    "angle_el_deg,angle_estimated_el_deg,angle_error_el_deg,"
    "i_q_a,i_q_estimated_a,i_q_reference_a,i_d_a,i_d_estimated_a,i_a_a,i_b_a,i_c_a,"
    "v_d_v,v_q_v,duty_a,duty_b,duty_c,bus_v,load_torque_nm,torque_nm,fault\n";

using Out = std::back_insert_iterator<fmt::memory_buffer>;

void write_speed(Out out, const Tick &t)
{
    const drive_t &drive = t.sim->drive();
    const Bases &bases = t.sim->bases();
    const bool speed_mode = t.mode == DriveMode::speed;
    const double asked = bases.rpm_from_step(drive.speed_reference);
    fmt::format_to(out, FMT_COMPILE("{:.7f},{},{:.6g},{:.6g},{:.6g},{:.6g},"), t.time_s,
                   state_name(drive.state), speed_mode ? t.command : asked,
                   t.truth.omega_mech_rad_s * RPM_PER_RAD_S, bases.rpm_from_step(t.speed_estimate),
                   bases.rpm_from_step(drive.speed_loop.reference));
}

void write_angle(Out out, const Tick &t)
{
    const double turns = static_cast<double>(t.position_estimate_q32) / Q32;
    const auto angle = static_cast<uint32_t>(static_cast<uint64_t>(t.position_estimate_q32));
    fmt::format_to(out, FMT_COMPILE("{:.7g},{:.7g},{:.7g},{:.6g},{:.6g},{:.6g},"),
                   t.mode == DriveMode::position ? t.command : 0.0, t.truth.theta_mech_rad,
                   turns * 2.0 * PI / t.sim->bases().pole_pairs, t.truth.theta_el_rad * DEG_PER_RAD,
                   static_cast<int32_t>(angle) * DEG_PER_STEP, angle_error_deg(t));
}

void write_current(Out out, const Tick &t)
{
    const drive_t &drive = t.sim->drive();
    const double unit = t.sim->bases().current_a / Q15;
    fmt::format_to(out, FMT_COMPILE("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},"),
                   t.truth.i_q_a, drive.observer.current.q * unit,
                   drive.signals.current_ref.q * unit, t.truth.i_d_a,
                   drive.observer.current.d * unit, t.truth.i_abc_a[0], t.truth.i_abc_a[1],
                   t.truth.i_abc_a[2]);
}

void write_power(Out out, const Tick &t)
{
    const drive_t &drive = t.sim->drive();
    const double unit = t.sim->bases().voltage_v / Q15;
    const double full = t.sim->cfg().modulator.timer_counts;
    const compare_t &compare = t.sim->out().compare;
    fmt::format_to(out, FMT_COMPILE("{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{}\n"),
                   drive.signals.voltage.d * unit, drive.signals.voltage.q * unit,
                   compare.phase[0] / full, compare.phase[1] / full, compare.phase[2] / full,
                   t.truth.bus_v, t.load_nm, t.truth.torque_nm, fault_text(drive.fault.id)->name);
}

} // namespace

Trace::Trace(const std::string &path, bool with_prelude)
    : path_(path), with_prelude_(with_prelude), file_(std::fopen(path.c_str(), "wb"))
{
    if (!file_) {
        fail("cannot create the trace");
    }
    buffer_.append(HEADER, HEADER + std::strlen(HEADER));
}

void Trace::add(const Tick &tick)
{
    if (tick.time_s < 0 && !with_prelude_) {
        return;
    }
    const Out out(buffer_);
    write_speed(out, tick);
    write_angle(out, tick);
    write_current(out, tick);
    write_power(out, tick);
    if (buffer_.size() > FLUSH_BYTES) {
        flush();
    }
}

void Trace::flush()
{
    if (std::fwrite(buffer_.data(), 1, buffer_.size(), file_.get()) != buffer_.size()) {
        fail("cannot write the trace");
    }
    buffer_.clear();
}

void Trace::close()
{
    flush();
    if (std::fclose(file_.release()) != 0) {
        fail("cannot write the trace");
    }
}

void Trace::fail(const char *doing) const
{
    throw TraceError(fmt::format("{}: {}: {}", path_, doing, std::strerror(errno)));
}

} // namespace nf
