// SPDX-License-Identifier: MIT
#include "board_commands.h"
#include "fault_line.h"
#include "found_fault.h"
#include "live_view.h"
#include "measured.h"
#include "names.h"
#include "numbers.h"
#include "temperature_sensor.h"

#include <algorithm>
#include <deque>
#include <vector>

#include <fmt/format.h>

#include <curses.h>

namespace nf::live
{
namespace
{

constexpr double EVERY_S = 0.1;
constexpr std::size_t LINES_KEPT = 500;
constexpr int KEY_DELETE_BEFORE = 127;

// A name and its value, as the view has them below each other.
using Rows = std::vector<std::pair<std::string, std::string>>;

// Nothing of the rotor is shown that nobody knows.
void add_rotor(Rows &rows, const Simulation &sim)
{
    const drive_t &drive = sim.drive();
    const Bases &bases = sim.bases();
    const auto ampere = [&](int32_t raw) { return raw / Q15 * bases.current_a; };
    const auto volt = [&](int32_t raw) { return raw / Q15 * bases.voltage_v; };
    const double rpm = bases.rpm_from_step(drive_speed(&drive));
    if (!drive_is_controlled(drive.state)) {
        rows.emplace_back("speed", drive_knows_rotor(&drive) ? fmt::format("{:.1f} rpm", rpm)
                                                             : "unknown: the gates are open");
        return;
    }
    rows.emplace_back("speed", fmt::format("{:.1f} of {:.1f} rpm", rpm,
                                           bases.rpm_from_step(drive.motion.speed_reference)));
    const dq_t current = measured_current(sim);
    rows.emplace_back("current",
                      fmt::format("q {:.3f} A of {:.3f} A, d {:.3f} A", ampere(current.q),
                                  ampere(drive.control.current_ref.q), ampere(current.d)));
    rows.emplace_back("voltage",
                      fmt::format("q {:.2f} V, d {:.2f} V", volt(drive.control.voltage.q),
                                  volt(drive.control.voltage.d)));
}

// In one unit, that of the console.
std::string temperature_text(uint16_t count, const BoardSettings *board)
{
    return board == nullptr ? fmt::format("{} counts, --board FILE tells °C", count)
                            : fmt::format("{:.0f} °C", temperature_at(*board, count));
}

void add_drive(Rows &rows, const Simulation &sim, const BoardSettings *board)
{
    const drive_t &drive = sim.drive();
    const Bases &bases = sim.bases();
    rows.emplace_back("state", state_and_gates(drive));
    add_rotor(rows, sim);
    rows.emplace_back("bus", fmt::format("{:.2f} V", drive.bus / Q15 * bases.voltage_v));
    rows.emplace_back("temperature", temperature_text(sim.in().adc_temperature, board));
    if (drive.state == DRIVE_STATE_FAULT) {
        const FoundFault fault = found_fault(drive, bases);
        rows.emplace_back("fault", fault_measure(fault, bases, board));
        rows.emplace_back("", fault.advice);
    }
}

Rows rows_of(const Follower &follower, double bytes_per_s)
{
    const Shadow &shadow = follower.shadow();
    const Health &health = follower.health();
    Rows rows;
    rows.emplace_back("board", follower.about().name);
    if (shadow.is_in_step()) {
        add_drive(rows, shadow.sim(), follower.board());
    } else {
        rows.emplace_back("state", follower.no_stream().empty()
                                       ? "not in step"
                                       : "not in step: " + follower.no_stream());
    }
    rows.emplace_back("processor",
                      fmt::format("load {} %, late ticks {}{}", health.load_pct, health.late_ticks,
                                  health.tick_lost ? ", NO CONTROL TICK" : ""));
    rows.emplace_back("command", fmt::format("by {}, last reset: {}", health.source, health.reset));
    rows.emplace_back("line", fmt::format("{:.0f} bytes/s, {} broken, {} gaps", bytes_per_s,
                                          follower.broken(), follower.gaps().size()));
    rows.emplace_back("checked", fmt::format("tick {}, {} hashes, {} departures", shadow.next(),
                                             shadow.hashes_compared(), follower.departures()));
    return rows;
}

// A line at the width of the screen, cut between words where there is one.
std::vector<std::string> wrapped(const std::string &text, std::size_t width)
{
    std::vector<std::string> lines;
    std::size_t at = 0;
    while (text.size() - at > width) {
        const std::size_t blank = text.rfind(' ', at + width);
        const bool has_blank = blank != std::string::npos && blank > at;
        const std::size_t end = has_blank ? blank : at + width;
        lines.push_back(text.substr(at, end - at));
        at = has_blank ? end + 1 : end;
    }
    lines.push_back(text.substr(at));
    return lines;
}

class Screen : public LiveView
{
public:
    Screen()
    {
        initscr();
        set_up();
    }

    ~Screen() override
    {
        endwin();
    }
    Screen(const Screen &) = delete;
    Screen &operator=(const Screen &) = delete;

    void say(const std::string &line) override
    {
        for (std::size_t at = 0; at <= line.size();) {
            const std::size_t end = std::min(line.find('\n', at), line.size());
            lines_.push_back(line.substr(at, end - at));
            at = end + 1;
        }
        while (lines_.size() > LINES_KEPT) {
            lines_.pop_front();
        }
        draw();
    }

    void show(const Follower &follower) override
    {
        const double now_s = follower.now_s();
        if (now_s - shown_s_ < EVERY_S) {
            return;
        }
        const uint64_t bytes = follower.bytes_in();
        rows_ = rows_of(follower, static_cast<double>(bytes - bytes_) / (now_s - shown_s_));
        bytes_ = bytes;
        shown_s_ = now_s;
        draw();
    }

    std::optional<std::string> typed() override
    {
        for (int key = getch(); key != ERR; key = getch()) {
            if (key == '\n' || key == '\r' || key == KEY_ENTER) {
                std::string line;
                line.swap(input_);
                say("> " + line);
                return line;
            }
            take_key(key);
            draw();
        }
        return std::nullopt;
    }

    void leave() override
    {
        endwin();
    }

    void enter() override
    {
        set_up();
        clear();
        draw();
    }

private:
    static void set_up()
    {
        cbreak();
        noecho();
        keypad(stdscr, TRUE);
        nodelay(stdscr, TRUE);
    }

    void take_key(int key)
    {
        const bool back = key == KEY_BACKSPACE || key == KEY_DELETE_BEFORE || key == '\b';
        if (back && !input_.empty()) {
            input_.pop_back();
        } else if (key >= ' ' && key < KEY_DELETE_BEFORE) {
            input_ += static_cast<char>(key);
        }
    }

    // As far as the width goes, above the line for input.
    static void put(int row, const std::string &text)
    {
        if (row < LINES - 1) {
            mvaddnstr(row, 0, text.c_str(), COLS);
        }
    }

    // Returns the row behind them.
    int draw_values() const
    {
        constexpr int NAME_WIDTH = 13;
        int row = 0;
        for (const auto &[name, value] : rows_) {
            std::string left = name;
            const auto width = static_cast<std::size_t>(std::max(1, COLS - NAME_WIDTH));
            for (const std::string &part : wrapped(value, width)) {
                put(row++, fmt::format("{:{}}{}", left, NAME_WIDTH, part));
                left.clear();
            }
        }
        return row;
    }

    // The newest ones, as many as there is room for.
    void draw_lines(int row) const
    {
        std::vector<std::string> rows;
        for (const std::string &line : lines_) {
            const std::vector<std::string> parts =
                wrapped(line, static_cast<std::size_t>(std::max(1, COLS)));
            rows.insert(rows.end(), parts.begin(), parts.end());
        }
        const auto room = static_cast<std::size_t>(std::max(0, LINES - 1 - row));
        const std::size_t from = rows.size() > room ? rows.size() - room : 0;
        for (std::size_t k = from; k < rows.size(); k++) {
            put(row++, rows[k]);
        }
    }

    void draw() const
    {
        erase();
        draw_lines(draw_values() + 1);
        mvaddnstr(LINES - 1, 0, ("> " + input_).c_str(), COLS);
        refresh();
    }

    Rows rows_;
    std::deque<std::string> lines_;
    std::string input_;
    double shown_s_ = 0;
    uint64_t bytes_ = 0;
};

} // namespace

std::unique_ptr<LiveView> terminal_view()
{
    return std::make_unique<Screen>();
}

} // namespace nf::live
