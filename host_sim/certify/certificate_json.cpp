// SPDX-License-Identifier: MIT
#include "certificate_json.h"

#include <nlohmann/json.hpp>

namespace nf::certify
{
namespace
{

using Json = nlohmann::ordered_json;

Json json_of_box(const Campaign &campaign)
{
    Json box = Json::array();
    for (const Axis &axis : campaign.box) {
        box.push_back({{"key", axis.key},
                       {"title", axis.title},
                       {"unit", axis.unit},
                       {"low", axis.low},
                       {"high", axis.high},
                       {"from", ground_text(axis.ground)},
                       {"better", axis.better}});
    }
    return box;
}

Json json_of(const Campaign &campaign, const Spread &spread)
{
    const Json most = spread.most ? Json(campaign.box[spread.most->axis].key) : Json(nullptr);
    return {{"least", spread.least},
            {"low_5_pct", spread.low},
            {"median", spread.middle},
            {"depends_most_on", most}};
}

Json json_of_influences(const Campaign &campaign, const Summary &summary)
{
    Json all = Json::array();
    for (const Influence &influence : summary.influences) {
        all.push_back({{"key", campaign.box[influence.axis].key},
                       {"share", influence.share},
                       {"mean_margin_by_quarter", influence.margin},
                       {"failed_by_quarter", influence.failed}});
    }
    return all;
}

Json json_of(const Campaign &campaign, const Summary &summary)
{
    if (!summary.refusal.empty()) {
        return {{"refused", summary.refusal}};
    }
    return {{"runs", summary.runs},
            {"locked", summary.locked},
            {"locked_pct_at_least", 100 * summary.least_locked()},
            {"slow", summary.slow},
            {"stopped", summary.stopped},
            {"lost", summary.lost},
            {"swings", summary.swings},
            {"faults", summary.faults},
            {"margin",
             {{"worst", json_of(campaign, summary.worst)},
              {"current", json_of(campaign, summary.current)},
              {"bus", json_of(campaign, summary.voltage)},
              {"speed", json_of(campaign, summary.speed)},
              {"angle", json_of(campaign, summary.angle)}}},
            {"speed_reached", json_of(campaign, summary.reached)},
            {"highest_speed_rpm", summary.highest_rpm},
            {"depends_on", json_of_influences(campaign, summary)}};
}

Json json_of_runs(const Campaign &campaign, const Series &series)
{
    Json runs = Json::array();
    for (std::size_t run = 0; run < series.trials.size(); run++) {
        const Trial &trial = series.trials[run];
        Json draw;
        for (std::size_t k = 0; k < campaign.box.size(); k++) {
            draw[campaign.box[k].key] = campaign.points[run][k];
        }
        runs.push_back({{"verdict", verdict_text(trial.verdict)},
                        {"fault", trial.fault},
                        {"swings", trial.swings},
                        {"current", trial.margins.current},
                        {"bus", trial.margins.voltage},
                        {"speed", trial.margins.speed},
                        {"angle", trial.margins.angle},
                        {"reached", trial.margins.reached},
                        {"draw", draw}});
    }
    return runs;
}

} // namespace

std::string json_of(const Campaign &campaign, const Judgement &judgement)
{
    const Config &config = campaign.series.front().believed;
    const Summary &best = judgement.summaries[judgement.best];
    Json json;
    json["motor"] = config.motor.name;
    json["board"] = config.board.name;
    json["notes"] = config.scenario.notes;
    json["seed"] = campaign.seed;
    json["runs"] = best.runs;
    json["runs_planned"] = campaign.planned;
    json["box"] = json_of_box(campaign);
    for (const Summary &summary : judgement.summaries) {
        json["tunings"][summary.tuning] = json_of(campaign, summary);
    }
    json["recommended"] = best.tuning;
    json["why"] = judgement.why;
    json["limiting"] =
        judgement.limiting ? Json(campaign.box[*judgement.limiting].key) : Json(nullptr);
    if (judgement.bound) {
        json["all_locked_below"] = {{"key", campaign.box[judgement.bound->axis].key},
                                    {"value", judgement.bound->up_to},
                                    {"runs", judgement.bound->runs}};
    }
    json["draws"] = json_of_runs(campaign, campaign.series[judgement.best]);
    return json.dump(2) + '\n';
}

} // namespace nf::certify
