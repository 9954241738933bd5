// SPDX-License-Identifier: MIT
#include "certificate_page.h"

#include "sentences.h"
#include "si.h"
#include "worst_map.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>

namespace nf::certify
{
namespace
{

constexpr const char *STYLE = R"(<style>
:root { color-scheme: light dark; --page: #fcfcfb; --ink: #0b0b0b; --quiet: #52514e; --line: #e1e0d9; --card: #ffffff;
  --good: #006300; --bad: #d03b3b; --bar: #2a78d6;
  --u0: #eef4fc; --u1: #cde2fb; --u2: #9ec5f4; --u3: #6da7ec; --u4: #3987e5; --u5: #1c5cab; --u6: #0d366b; }
@media (prefers-color-scheme: dark) { :root { --page: #1a1a19; --ink: #ffffff; --quiet: #c3c2b7; --line: #383835;
  --card: #232322; --good: #0ca30c; --bad: #e66767; --bar: #3987e5;
  --u0: #1f2733; --u1: #0d366b; --u2: #184f95; --u3: #256abf; --u4: #3987e5; --u5: #86b6ef; --u6: #cde2fb; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 24px 16px 48px; max-width: 1000px; background: var(--page); color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", sans-serif; }
h1 { font-size: 22px; line-height: 1.3; margin: 0 0 4px; } h2 { font-size: 16px; margin: 32px 0 8px; }
p { margin: 6px 0; max-width: 75ch; } .quiet { color: var(--quiet); }
.result { border: 1px solid var(--line); border-left: 6px solid var(--good); border-radius: 4px; background: var(--card);
  padding: 12px 16px; margin: 16px 0; } .result.bad { border-left-color: var(--bad); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { text-align: right; white-space: nowrap; padding: 4px 12px 4px 0; border-bottom: 1px solid var(--line); vertical-align: top; }
th { color: var(--quiet); font-weight: 600; } th:first-child, td:first-child, .left { text-align: left; }
tr.best td { font-weight: 600; }
svg { display: block; } svg.map { max-width: 100%; height: auto; } svg.small { margin-top: 4px; } svg text { fill: var(--quiet); font: 12px system-ui, sans-serif; }
.u0 { fill: var(--u0); } .u1 { fill: var(--u1); } .u2 { fill: var(--u2); } .u3 { fill: var(--u3); } .u4 { fill: var(--u4); }
.u5 { fill: var(--u5); } .u6 { fill: var(--u6); }
.none { fill: none; stroke: var(--line); } .frame { fill: none; stroke: var(--quiet); }
.run { fill: var(--ink); fill-opacity: .45; stroke: var(--page); stroke-width: 1; }
.fail { stroke: var(--bad); stroke-width: 2.5; fill: none; } .halo { stroke: var(--page); stroke-width: 5; fill: none; }
.bar { fill: var(--bar); } .track { fill: var(--line); }
</style>
)";

std::string safe(const std::string &text)
{
    std::string html;
    for (const char c : text) {
        switch (c) {
        case '&':
            html += "&amp;";
            break;
        case '<':
            html += "&lt;";
            break;
        case '>':
            html += "&gt;";
            break;
        default:
            html += c;
        }
    }
    return html;
}

std::string range_text(const Axis &axis)
{
    return fmt::format("{}{}", safe(axis.title),
                       axis.unit.empty() ? "" : fmt::format(", {}", axis.unit));
}

std::string tuning_row(const Summary &summary, bool is_best)
{
    if (!summary.refusal.empty()) {
        return fmt::format(
            "<tr><td>{}</td><td colspan=\"7\" class=\"left\">refused: {}</td></tr>\n",
            safe(summary.tuning), safe(summary.refusal));
    }
    return fmt::format(
        "<tr{}><td>{}{}</td><td>{} of {}</td><td>{:.1f} %</td><td>{}</td><td>{}</td><td>{}</td>"
        "<td>{}</td><td>{:.2f}</td></tr>\n",
        is_best ? " class=\"best\"" : "", safe(summary.tuning), is_best ? " (take this one)" : "",
        summary.locked, summary.runs, IN_PER_CENT * summary.least_locked(), summary.slow,
        summary.stopped, summary.lost, summary.swings, summary.worst.low);
}

std::string tunings_table(const Judgement &judgement)
{
    std::string rows;
    for (std::size_t k = 0; k < judgement.summaries.size(); k++) {
        rows += tuning_row(judgement.summaries[k], k == judgement.best);
    }
    return "<div class=\"scroll\"><table>\n<tr><th>tuning</th><th>locked</th><th>of all, at least</th><th>slow</th>"
           "<th>stopped</th><th>lost</th><th>swings</th><th>margin of 95 %</th></tr>\n" +
           rows + "</table></div>\n";
}

std::string spread_row(const Campaign &campaign, const char *title, const char *meaning,
                       const Spread &spread)
{
    const std::string most =
        spread.most ? fmt::format("{}, {:.0f} %", safe(campaign.box[spread.most->axis].title),
                                  IN_PER_CENT * spread.most->share)
                    : "";
    return fmt::format(
        "<tr><td>{}</td><td>{:.2f}</td><td>{:.2f}</td><td>{:.2f}</td><td class=\"left\">{}</td>"
        "<td class=\"left quiet\">{}</td></tr>\n",
        title, spread.least, spread.low, spread.middle, most, meaning);
}

std::string margins_table(const Campaign &campaign, const Summary &best)
{
    const auto row = [&](const char *title, const char *meaning, const Spread &spread) {
        return spread_row(campaign, title, meaning, spread);
    };
    return "<div class=\"scroll\"><table>\n<tr><th>margin</th><th>least</th><th>5 %</th><th>half</th>"
           "<th class=\"left\">depends most on</th><th class=\"left\">1 is all of the room, 0 is the limit</th></tr>\n" +
           row("current", "largest phase current against the trip", best.current) +
           row("bus", "mean voltage under the load against the voltage circle", best.voltage) +
           row("speed", "rms error of the estimate against 5 % of rated speed", best.speed) +
           row("angle", "error of the angle against 90 degrees electrical", best.angle) +
           row("speed reached", "mean speed over the command; below 0.95 a run is slow",
               best.reached) +
           "</table></div>\n";
}

// The map in pixels.
constexpr double SIDE = 440;
constexpr double LEFT = 74;
constexpr double TOP = 14;
constexpr double WIDTH = 640;
constexpr double HEIGHT = 510;

// A colour is for margins from here up to the one before it; the last one is down to 0.
constexpr double FROM[] = {0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0};
constexpr int STEPS = 7;

int colour_of(double margin)
{
    return static_cast<int>(std::find_if(std::begin(FROM), std::end(FROM) - 1,
                                         [&](double from) { return margin >= from; }) -
                            std::begin(FROM));
}

std::string cell_of(const WorstMap &map, std::size_t column, std::size_t row)
{
    const Cell &cell = map.at(column, row);
    const double size = SIDE / static_cast<double>(map.side);
    const double x = LEFT + size * static_cast<double>(column);
    const double y = TOP + SIDE - size * static_cast<double>(row + 1);
    const std::string kind = cell.runs == 0 ? "none" : fmt::format("u{}", colour_of(cell.worst));
    const std::string told = cell.runs == 0 ? "no run"
                                            : fmt::format("{} runs, {} failed, worst margin {:.2f}",
                                                          cell.runs, cell.failed, cell.worst);
    return fmt::format(
        "<rect class=\"{}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" rx=\"2\">"
        "<title>{}</title></rect>\n",
        kind, x + 1, y + 1, size - 2, size - 2, told);
}

std::string mark_of(const Trial &trial, double x, double y)
{
    const std::string told =
        fmt::format("<title>{}{}{}, worst margin {:.2f}</title>", verdict_text(trial.verdict),
                    trial.fault.empty() ? "" : ", ", trial.fault, trial.worst());
    if (is_locked(trial.verdict)) {
        return fmt::format(
            "<circle class=\"run\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\">{}</circle>\n", x, y,
            told);
    }
    const std::string cross = fmt::format("d=\"M{:.1f} {:.1f}l10 10m0 -10l-10 10\"", x - 5, y - 5);
    return fmt::format("<path class=\"halo\" {0}/><path class=\"fail\" {0}>{1}</path>\n", cross,
                       told);
}

std::string marks_of(const Campaign &campaign, const Judgement &judgement, const WorstMap &map)
{
    const std::vector<Trial> &trials = campaign.series[judgement.best].trials;
    const auto share = [&](std::size_t axis, std::size_t run) {
        const Axis &on = campaign.box[axis];
        return (campaign.points[run][axis] - on.low) / (on.high - on.low);
    };
    std::string text;
    for (const bool locked : {true, false}) { // the failures on top
        for (std::size_t run = 0; run < trials.size(); run++) {
            if (is_locked(trials[run].verdict) == locked) {
                text += mark_of(trials[run], LEFT + SIDE * share(map.across, run),
                                TOP + SIDE * (1 - share(map.up, run)));
            }
        }
    }
    return text;
}

std::string label(double x, double y, const char *anchor, const std::string &text)
{
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y,
                       anchor, text);
}

std::string scale_of(const Campaign &campaign, const WorstMap &map)
{
    const Axis &across = campaign.box[map.across];
    const Axis &up = campaign.box[map.up];
    std::string text;
    for (const double share : {0.0, 0.5, 1.0}) {
        text += label(LEFT + SIDE * share, TOP + SIDE + 18, "middle",
                      fmt::format("{:.4g}", across.low + share * (across.high - across.low)));
        text += label(LEFT - 8, TOP + SIDE * (1 - share) + 4, "end",
                      fmt::format("{:.4g}", up.low + share * (up.high - up.low)));
    }
    const double middle = TOP + SIDE / 2;
    return text + label(LEFT + SIDE / 2, TOP + SIDE + 40, "middle", range_text(across)) +
           fmt::format(
               "<text transform=\"translate(16 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
               middle, range_text(up));
}

std::string legend()
{
    constexpr double x = LEFT + SIDE + 24;
    std::string text = label(x, TOP + 12, "start", "worst margin");
    for (int step = 0; step < STEPS; step++) {
        const double y = TOP + 22 + 22 * step;
        text += fmt::format(
            "<rect class=\"u{}\" x=\"{}\" y=\"{}\" width=\"22\" height=\"20\" rx=\"2\"/>\n", step,
            x, y);
        text += label(x + 30, y + 15, "start",
                      fmt::format("{:.2f} to {:.2f}", FROM[step], step == 0 ? 1 : FROM[step - 1]));
    }
    const double y = TOP + 22 + 22 * STEPS + 20;
    return text + fmt::format("<circle class=\"run\" cx=\"{}\" cy=\"{}\" r=\"3.5\"/>", x + 10, y) +
           label(x + 30, y + 4, "start", "locked") +
           fmt::format("<path class=\"fail\" d=\"M{} {}l10 10m0 -10l-10 10\"/>", x + 5, y + 19) +
           label(x + 30, y + 28, "start", "failed");
}

std::string map_svg(const Campaign &campaign, const Judgement &judgement)
{
    const WorstMap map = map_of(campaign, judgement);
    std::string text = fmt::format(
        "<svg class=\"map\" viewBox=\"0 0 {} {}\" width=\"{}\" role=\"img\" aria-label=\"worst margin over "
        "{} and {}\">\n",
        WIDTH, HEIGHT, WIDTH, safe(campaign.box[map.across].title),
        safe(campaign.box[map.up].title));
    for (std::size_t row = 0; row < map.side; row++) {
        for (std::size_t column = 0; column < map.side; column++) {
            text += cell_of(map, column, row);
        }
    }
    return text + marks_of(campaign, judgement, map) + scale_of(campaign, map) + legend() +
           "</svg>\n";
}

std::string influence_row(const Campaign &campaign, const Influence &influence)
{
    constexpr double width = 160;
    const Axis &axis = campaign.box[influence.axis];
    std::string text = fmt::format(
        "<tr><td>{}</td><td><svg class=\"small\" width=\"{}\" height=\"14\"><rect class=\"track\" y=\"6\" width=\"{}\" height=\"2\"/>"
        "<rect class=\"bar\" y=\"2\" width=\"{:.1f}\" height=\"10\" rx=\"2\"/></svg></td><td>{:.0f} %</td>",
        safe(axis.title), width, width, width * influence.share, IN_PER_CENT * influence.share);
    for (std::size_t quarter = 0; quarter < influence.margin.size(); quarter++) {
        text += fmt::format("<td>{:.2f}{}</td>", influence.margin[quarter],
                            influence.failed[quarter] > 0
                                ? fmt::format(", {} failed", influence.failed[quarter])
                                : "");
    }
    return text + "</tr>\n";
}

// How to know better what stands out.
std::string advice_list(const Campaign &campaign, const std::vector<Influence> &outstanding)
{
    std::string text;
    for (const Influence &influence : outstanding) {
        const Axis &axis = campaign.box[influence.axis];
        if (!axis.better.empty()) {
            text += fmt::format("<p><code>{}</code>: {}</p>\n", axis.key, safe(axis.better));
        }
    }
    return text;
}

std::string influences_table(const Campaign &campaign, const Summary &best)
{
    const std::vector<Influence> outstanding = best.outstanding();
    std::string rows;
    for (const Influence &influence : outstanding) {
        rows += influence_row(campaign, influence);
    }
    const std::string table =
        "<div class=\"scroll\"><table>\n<tr><th>value</th><th class=\"left\" colspan=\"2\">explains</th>"
        "<th>lowest quarter</th><th>second</th><th>third</th><th>highest</th></tr>\n" +
        rows + "</table></div>\n";
    return (outstanding.empty() ? "" : table) +
           fmt::format("<p>{} explains less than {:.0f} %, which may be chance.</p>\n",
                       outstanding.empty() ? "Each value" : "Any other value",
                       IN_PER_CENT * share_by_chance(best.runs)) +
           advice_list(campaign, outstanding);
}

std::string box_table(const Campaign &campaign)
{
    std::string rows;
    for (const Axis &axis : campaign.box) {
        rows += fmt::format(
            "<tr><td>{}</td><td>{:.4g}</td><td>{:.4g}</td><td class=\"left\">{}</td><td class=\"left\">{}"
            "</td><td class=\"left\"><code>{}</code></td></tr>\n",
            safe(axis.title), axis.low, axis.high, axis.unit, ground_text(axis.ground), axis.key);
    }
    return "<div class=\"scroll\"><table>\n<tr><th>value</th><th>from</th><th>to</th><th></th><th class=\"left\">by</th>"
           "<th class=\"left\">key</th></tr>\n" +
           rows + "</table></div>\n";
}

} // namespace

std::string page_of(const Campaign &campaign, const Judgement &judgement)
{
    const Summary &best = judgement.summaries[judgement.best];
    const bool is_good = best.locked == best.runs;
    return "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n"
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n" +
           fmt::format("<title>{}</title>\n", safe(head_of(campaign))) + STYLE +
           fmt::format(
               "<h1>{}</h1>\n<p class=\"quiet\">Certificate of a simulated drive, {} machines a tuning, seed {}.</p>\n",
               safe(head_of(campaign)), best.runs, campaign.seed) +
           fmt::format("<div class=\"result{}\"><p><b>{}</b></p><p>{}</p></div>\n",
                       is_good ? "" : " bad", safe(result_of(campaign, judgement)),
                       safe(limit_of(campaign, judgement))) +
           "<h2>Tunings, on the same machines</h2>\n" + tunings_table(judgement) +
           fmt::format("<p>Take <b>{}</b>: {}.</p>\n", safe(best.tuning), safe(judgement.why)) +
           fmt::format("<h2>Room that is left with {}, in the locked runs</h2>\n",
                       safe(best.tuning)) +
           margins_table(campaign, best) +
           "<h2>Worst margin over the two values that matter most</h2>\n" +
           map_svg(campaign, judgement) +
           "<p class=\"quiet\">A cell has the colour of the worst run in it. The worst margin is the least of current, speed "
           "and angle; where the rotor is not held it is 0.</p>\n" +
           "<h2>What the worst margin depends on</h2>\n<p class=\"quiet\">Share of its variance that a value alone explains, and "
           "its mean in each quarter of the range of the value.</p>\n" +
           influences_table(campaign, best) +
           "<h2>The box</h2>\n<p class=\"quiet\">Each machine is a draw from these ranges, evenly. The drive believes the "
           "files.</p>\n" +
           box_table(campaign) + "</html>\n";
}

} // namespace nf::certify
