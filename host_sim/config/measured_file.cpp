// SPDX-License-Identifier: MIT
#include "measured_file.h"

#include "bars.h"
#include "schema.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>

#include <fmt/format.h>

namespace nf
{
namespace
{

const Origin IDENTIFIED = {"identified motor", 0};
const char *const CONDITIONS[] = {"measured.temperature_c", "measured.bus_v", "measured.current_a",
                                  "measured.speed_rpm", "measured.current_noise_lsb"};

bool is_bar(const std::string &key)
{
    return key.find("_std_pct") != std::string::npos ||
           key.find("_bound_pct") != std::string::npos || key.find("_bar_") != std::string::npos;
}

bool is_condition(const std::string &key)
{
    return std::find(std::begin(CONDITIONS), std::end(CONDITIONS), key) != std::end(CONDITIONS);
}

bool is_control(char c)
{
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
}

std::string comment(const std::string &head)
{
    std::istringstream lines(head);
    std::string text;
    for (std::string line; std::getline(lines, line);) {
        std::replace_if(line.begin(), line.end(), is_control, '?');
        text += line.empty() ? "#\n" : "# " + line + '\n';
    }
    return text.empty() ? text : text + '\n';
}

Node node_of(const std::string &text)
{
    Node node;
    node.kind = Node::Kind::text;
    node.text = text;
    node.origin = IDENTIFIED;
    return node;
}

Node node_of(int number)
{
    Node node;
    node.kind = Node::Kind::integer;
    node.integer = number;
    node.origin = IDENTIFIED;
    return node;
}

Node node_of(double number)
{
    Node node;
    node.kind = Node::Kind::real;
    node.real = number;
    node.origin = IDENTIFIED;
    return node;
}

std::string real_text(const std::string &key, double value, double bar)
{
    if (is_bar(key) && value > 0) {
        return two_digits(value);
    }
    return is_condition(key) ? fmt::format("{:.4g}", value) : within_bar(value, bar);
}

std::string bar_comment(const Field &field, double bar)
{
    return bar > 0 ? fmt::format(" # ± {}{}{}", two_digits(bar), *field.unit == '\0' ? "" : " ",
                                 field.unit)
                   : "";
}

// The sections of a motor file, written from where the settings are.
class MotorFile
{
public:
    MotorFile(const MotorSettings &motor, const MeasuredSettings &measured)
    {
        written_.motor = motor;
        written_.measured = measured;
    }

    // What is on the shaft; "" where all is at its default.
    std::string sensor()
    {
        std::string lines;
        for (const Field &field : schema()) {
            const std::string text = field.value_text(written_);
            if (std::string(field.section) == "sensor" && text != field.value_text(default_)) {
                lines += fmt::format(
                    "{} = {}{}\n", field.key, text,
                    bar_comment(field, bar_of(written_.motor, written_.measured, field.name())));
            }
        }
        return lines.empty() ? lines : "[sensor]\n" + lines;
    }

    // "" where all is at its default.
    std::string section(const std::string &name)
    {
        std::string lines;
        for (const Field &field : schema()) {
            if (field.section == name) {
                lines += line(field);
            }
        }
        return lines.empty() ? lines : fmt::format("[{}]\n{}", name, lines);
    }

private:
    // "" for an optional key at its default.
    std::string line(const Field &field)
    {
        const Target target = field.target(written_);
        const Target untouched = field.target(default_);
        if (const auto *text = std::get_if<std::string *>(&target)) {
            check_value(field, node_of(**text));
            return fmt::format("{} = {}\n", field.key, toml_string(**text));
        }
        if (const auto *whole = std::get_if<int *>(&target)) {
            check_value(field, node_of(**whole));
            return fmt::format("{} = {}\n", field.key, **whole);
        }
        const double value = *std::get<double *>(target);
        check_value(field, node_of(value));
        if (!field.required && std::abs(value - *std::get<double *>(untouched)) <= 0) {
            return "";
        }
        const double bar = bar_of(written_.motor, written_.measured, field.name());
        return fmt::format("{} = {}{}\n", field.key, real_text(field.name(), value, bar),
                           bar_comment(field, bar));
    }

    Config written_;
    Config default_;
};

} // namespace

std::string measured_motor_file(const MotorSettings &motor, const MeasuredSettings &measured,
                                const std::string &head)
{
    MotorFile file(motor, measured);
    const std::string found = file.section("measured");
    const std::string sensor = file.sensor();
    return comment(head) + file.section("motor") + (sensor.empty() ? "" : '\n' + sensor) +
           (found.empty() ? "" : '\n' + found);
}

} // namespace nf
