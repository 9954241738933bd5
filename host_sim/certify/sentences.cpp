// SPDX-License-Identifier: MIT
#include "sentences.h"

#include <fmt/format.h>

namespace nf::certify
{

std::string head_of(const Campaign &campaign)
{
    const Config &config = campaign.series.front().believed;
    return fmt::format("{} on {}", config.motor.name, config.board.name);
}

std::string result_of(const Campaign &campaign, const Judgement &judgement)
{
    const Summary &best = judgement.summaries[judgement.best];
    const int runs = best.runs;
    const std::string stopped =
        runs < campaign.planned
            ? fmt::format(" It was stopped after {} of {} runs.", runs, campaign.planned)
            : "";
    return fmt::format("{} of {} machines are locked with the tuning {}: at least {:.1f} % of all "
                       "in the box, with 95 % confidence.{}",
                       best.locked, runs, best.tuning, 100 * best.least_locked(), stopped);
}

std::string limit_of(const Campaign &campaign, const Judgement &judgement)
{
    std::string text;
    if (judgement.bound) {
        const Axis &axis = campaign.box[judgement.bound->axis];
        text = fmt::format("All {} machines where the {} is below {:.3g} {} are locked. ",
                           judgement.bound->runs, axis.title, judgement.bound->up_to, axis.unit);
    }
    if (!judgement.limiting) {
        return text + "No single unknown stands out.";
    }
    const Axis &axis = campaign.box[*judgement.limiting];
    return text + fmt::format("The unknown that limits most is {} ({}). {}", axis.key, axis.title,
                              axis.better);
}

} // namespace nf::certify
