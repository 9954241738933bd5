// SPDX-License-Identifier: MIT
#include "trace.h"

#include "signals.h"

#include <array>
#include <iterator>
#include <vector>

namespace nf
{
namespace
{

// A signal and how it is written; a state or a fault is a word.
struct Column {
    const char *name;
    const char *form = "{:.6g}";
};

constexpr std::array<Column, 30> COLUMNS = {{
    {"time_s", "{:.7f}"},
    {"state"},
    {"speed_command_rpm"},
    {"speed_rpm"},
    {"speed_estimated_rpm"},
    {"speed_reference_rpm"},
    {"position_command_rad", "{:.7g}"},
    {"position_rad", "{:.7g}"},
    {"position_estimated_rad", "{:.7g}"},
    {"angle_el_deg"},
    {"angle_estimated_el_deg"},
    {"angle_error_el_deg"},
    {"i_q_a"},
    {"i_q_estimated_a"},
    {"i_q_reference_a"},
    {"i_d_a"},
    {"i_d_estimated_a"},
    {"i_a_a"},
    {"i_b_a"},
    {"i_c_a"},
    {"v_d_v"},
    {"v_q_v"},
    {"duty_a"},
    {"duty_b"},
    {"duty_c"},
    {"bus_v"},
    {"torque_command_nm"},
    {"load_torque_nm"},
    {"torque_nm"},
    {"fault"},
}};

struct Source {
    const SignalInfo *signal;
    const char *form;
};

const std::vector<Source> &sources()
{
    static const std::vector<Source> all = [] {
        std::vector<Source> found;
        found.reserve(COLUMNS.size());
        for (const Column &column : COLUMNS) {
            found.push_back({find_signal(column.name), column.form});
        }
        return found;
    }();
    return all;
}

std::string header()
{
    std::string line;
    for (const Column &column : COLUMNS) {
        line += line.empty() ? "" : ",";
        line += column.name;
    }
    return line + '\n';
}

void write_row(fmt::memory_buffer &buffer, const Tick &tick)
{
    const auto out = std::back_inserter(buffer);
    for (const Source &source : sources()) {
        const SignalInfo &signal = *source.signal;
        const bool is_word =
            signal.quantity == Quantity::state || signal.quantity == Quantity::fault;
        if (is_word) {
            fmt::format_to(out, "{}", word_text(signal, raw_value(signal, tick).value_or(0)));
        } else {
            fmt::format_to(out, fmt::runtime(source.form), si_value(signal, tick));
        }
        buffer.push_back(&source == &sources().back() ? '\n' : ',');
    }
}

} // namespace

Trace::Trace(const std::string &path, bool with_prelude) : with_prelude_(with_prelude), file_(path)
{
    const std::string names = header();
    buffer_.append(names.data(), names.data() + names.size());
}

void Trace::add(const Tick &tick)
{
    if (tick.time_s < 0 && !with_prelude_) {
        return;
    }
    write_row(buffer_, tick);
    if (buffer_.size() > OutputFile::WORTH_WRITING) {
        flush();
    }
}

void Trace::flush()
{
    file_.write({buffer_.data(), buffer_.size()});
    buffer_.clear();
}

void Trace::close()
{
    flush();
    file_.close();
}

} // namespace nf
