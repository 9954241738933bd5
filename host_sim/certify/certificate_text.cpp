// SPDX-License-Identifier: MIT
#include "certificate_text.h"

#include "sentences.h"
#include "si.h"

#include <fmt/format.h>

namespace nf::certify
{
namespace
{

const Config &config_of(const Campaign &campaign)
{
    return campaign.series.front().believed;
}

std::string tuning_line(const Summary &summary, bool is_best)
{
    if (!summary.refusal.empty()) {
        return fmt::format("  {:<14}  refused: {}\n", summary.tuning, summary.refusal);
    }
    return fmt::format("{} {:<14}{:>6} of {:<5}{:>8.1f} %{:>7}{:>8}{:>6}{:>9}{:>9.2f}\n",
                       is_best ? '*' : ' ', summary.tuning, summary.locked, summary.runs,
                       IN_PER_CENT * summary.least_locked(), summary.slow, summary.stopped,
                       summary.lost, summary.swings, summary.worst.low);
}

std::string fault_lines(const Summary &summary)
{
    std::string text;
    for (const auto &[name, runs] : summary.faults) {
        text += fmt::format("  {:<28}{:>8} runs\n", name, runs);
    }
    return text;
}

std::string spread_line(const Campaign &campaign, const char *title, const Spread &spread)
{
    const std::string most =
        spread.most ? fmt::format("  {}, {:.0f} %", campaign.box[spread.most->axis].title,
                                  IN_PER_CENT * spread.most->share)
                    : "";
    return fmt::format("  {:<44}{:>8.2f}{:>8.2f}{:>8.2f}{}\n", title, spread.least, spread.low,
                       spread.middle, most);
}

std::string margin_lines(const Campaign &campaign, const Summary &best)
{
    const double rated_rpm = config_of(campaign).motor.rated_speed_rpm;
    return fmt::format("{:<46}{:>8}{:>8}{:>8}  depends most on\n",
                       fmt::format("margins of the locked runs, {}", best.tuning), "least", "5 %",
                       "half") +
           spread_line(campaign, "current: peak of a phase to the trip", best.current) +
           spread_line(campaign, "bus: mean voltage to the circle, loaded", best.voltage) +
           spread_line(campaign, "speed: error of the estimate to lost", best.speed) +
           spread_line(campaign, "angle: error to 90 degrees", best.angle) +
           spread_line(campaign, "speed reached, of the command", best.reached) +
           fmt::format("  {:<44}{:>8.2f} of rated\n", "highest speed",
                       best.highest_rpm / rated_rpm);
}

std::string influence_line(const Axis &axis, const Influence &influence)
{
    std::string text =
        fmt::format("  {:<32}{:>5.0f} %  ", axis.title, IN_PER_CENT * influence.share);
    for (std::size_t quarter = 0; quarter < influence.margin.size(); quarter++) {
        text += fmt::format("{:>8.2f} ({})", influence.margin[quarter], influence.failed[quarter]);
    }
    return text + '\n';
}

std::string influence_lines(const Campaign &campaign, const Summary &best)
{
    std::string text =
        "the worst margin depends on        share    mean margin (failed), lowest to highest quarter\n";
    for (const Influence &influence : best.outstanding()) {
        text += influence_line(campaign.box[influence.axis], influence);
    }
    return text + fmt::format("  anything else: less than {:.0f} %, which may be chance\n",
                              IN_PER_CENT * share_by_chance(best.runs));
}

std::string box_lines(const Campaign &campaign)
{
    std::string text = fmt::format("{:<30}{:>12}{:>12}\n", "the box", "from", "to");
    for (const Axis &axis : campaign.box) {
        text += fmt::format("  {:<28}{:>12.4g}{:>12.4g}  {:<18} {}\n", axis.title, axis.low,
                            axis.high, axis.unit, ground_text(axis.ground));
    }
    return text;
}

} // namespace

std::string text_of(const Campaign &campaign, const Judgement &judgement)
{
    const Summary &best = judgement.summaries[judgement.best];
    std::string text = head_of(campaign) + '\n';
    for (const std::string &note : config_of(campaign).scenario.notes) {
        text += fmt::format("note: {}\n", note);
    }
    text += fmt::format("\n{}\n", box_lines(campaign));
    text += fmt::format("  {:<14}{:>15}{:>10}{:>7}{:>8}{:>6}{:>9}{:>9}\n", "tuning", "locked",
                        "at least", "slow", "stopped", "lost", "swings", "margin");
    for (std::size_t k = 0; k < judgement.summaries.size(); k++) {
        text += tuning_line(judgement.summaries[k], k == judgement.best);
    }
    text += fault_lines(best);
    text +=
        fmt::format("\n{}\n{}\n", margin_lines(campaign, best), influence_lines(campaign, best));
    return text + result_of(campaign, judgement) + '\n' +
           fmt::format("Take {}: {}.\n", best.tuning, judgement.why) +
           limit_of(campaign, judgement) + '\n';
}

} // namespace nf::certify
