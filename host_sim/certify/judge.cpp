// SPDX-License-Identifier: MIT
#include "judge.h"

#include "statistics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <tuple>

#include <fmt/format.h>

namespace nf::certify
{
namespace
{

constexpr double LOW = 0.05;         // the share of runs below Spread::low
constexpr double LEAST_SHARE = 0.05; // of the variance that is worth a word
constexpr double SAME_MARGIN = 0.02; // two margins that far apart are the same
constexpr double SIGMAS = 2;         // of a difference that is no chance

using Trials = std::vector<Trial>;

// Runs with their draws, and one number of each.
struct Sample {
    std::vector<const Point *> points;
    std::vector<const Trial *> trials;
    std::vector<double> values;
};

bool is_any(const Trial &)
{
    return true;
}

bool is_held(const Trial &trial)
{
    return is_locked(trial.verdict);
}

Sample sample_of(const Campaign &campaign, const Trials &trials, bool (*belongs)(const Trial &),
                 const std::function<double(const Trial &)> &value)
{
    Sample sample;
    for (std::size_t run = 0; run < trials.size(); run++) {
        if (belongs(trials[run])) {
            sample.points.push_back(&campaign.points[run]);
            sample.trials.push_back(&trials[run]);
            sample.values.push_back(value(trials[run]));
        }
    }
    return sample;
}

Influence influence_of(const Campaign &campaign, const Sample &sample, std::size_t k)
{
    const Axis &axis = campaign.box[k];
    Influence influence{k, 0, {}, {}};
    std::array<int, 4> runs{};
    std::vector<int> quarters;
    quarters.reserve(sample.values.size());
    for (std::size_t run = 0; run < sample.values.size(); run++) {
        quarters.push_back(quarter_of((*sample.points[run])[k], axis.low, axis.high));
        const auto at = static_cast<std::size_t>(quarters.back());
        runs[at]++;
        influence.margin[at] += (sample.values[run] - influence.margin[at]) / runs[at];
        influence.failed[at] += is_held(*sample.trials[run]) ? 0 : 1;
    }
    influence.share = explained_share(quarters, sample.values);
    return influence;
}

std::vector<Influence> influences_of(const Campaign &campaign, const Sample &sample)
{
    std::vector<Influence> all;
    all.reserve(campaign.box.size());
    for (std::size_t k = 0; k < campaign.box.size(); k++) {
        all.push_back(influence_of(campaign, sample, k));
    }
    std::sort(all.begin(), all.end(), [](const Influence &a, const Influence &b) {
        return std::tie(b.share, a.axis) < std::tie(a.share, b.axis);
    });
    return all;
}

Spread spread_of(const Campaign &campaign, const Sample &sample)
{
    const std::vector<Influence> influences = influences_of(campaign, sample);
    const bool stands_out =
        !influences.empty() &&
        influences[0].share >= share_by_chance(static_cast<int>(sample.values.size()));
    return {quantile(sample.values, 0), quantile(sample.values, LOW), quantile(sample.values, 0.5),
            stands_out ? std::optional(influences[0]) : std::nullopt};
}

void spread(const Campaign &campaign, const Trials &trials, Summary &summary)
{
    const auto of = [&](double Margins::*margin) {
        return spread_of(campaign, sample_of(campaign, trials, is_held, [=](const Trial &trial) {
                             return trial.margins.*margin;
                         }));
    };
    summary.current = of(&Margins::current);
    summary.voltage = of(&Margins::voltage);
    summary.speed = of(&Margins::speed);
    summary.angle = of(&Margins::angle);
    summary.reached = of(&Margins::reached);
    const Sample worst = sample_of(campaign, trials, is_any, std::mem_fn(&Trial::worst));
    summary.worst = spread_of(campaign, worst);
    summary.influences = influences_of(campaign, worst);
}

void count(const Trials &trials, Summary &summary)
{
    summary.runs = static_cast<int>(trials.size());
    for (const Trial &trial : trials) {
        summary.locked += is_held(trial) ? 1 : 0;
        summary.slow += trial.verdict == Verdict::slow ? 1 : 0;
        summary.stopped += trial.verdict == Verdict::stopped ? 1 : 0;
        summary.lost += trial.verdict == Verdict::lost ? 1 : 0;
        summary.swings += trial.swings ? 1 : 0;
        summary.highest_rpm =
            std::max(summary.highest_rpm, is_held(trial) ? trial.margins.highest_rpm : 0);
        if (!trial.fault.empty()) {
            summary.faults[trial.fault]++;
        }
    }
}

Summary summary_of(const Campaign &campaign, const Series &series)
{
    Summary summary;
    summary.tuning = series.tuning;
    summary.refusal = series.refusal;
    count(series.trials, summary);
    spread(campaign, series.trials, summary);
    return summary;
}

// What a tuning is chosen by.
bool is_good(const Trial &trial)
{
    return is_held(trial) && !trial.swings;
}

// How many machines are good with `a` and not with `b`.
int only_first(const Trials &a, const Trials &b)
{
    int runs = 0;
    for (std::size_t run = 0; run < a.size(); run++) {
        runs += is_good(a[run]) && !is_good(b[run]) ? 1 : 0;
    }
    return runs;
}

// Which of two tunings is better, if one is, and the words for it.
struct Comparison {
    std::optional<std::size_t> better;
    std::string why;
};

// On the same machines: by those that are good with one only, then by the margin that 95 of 100
// have.
Comparison compare(const Campaign &campaign, const std::vector<Summary> &all, std::size_t first,
                   std::size_t second)
{
    const int for_first = only_first(campaign.series[first].trials, campaign.series[second].trials);
    const int for_second =
        only_first(campaign.series[second].trials, campaign.series[first].trials);
    const bool is_second_good = for_second > for_first;
    const auto of = [&](bool is_second) { return is_second ? second : first; };
    const double a = all[first].worst.low;
    const double b = all[second].worst.low;
    const auto name = [&](bool is_second) { return all[of(is_second)].tuning; };
    if (std::abs(for_second - for_first) > SIGMAS * std::sqrt(for_first + for_second)) {
        return {
            of(is_second_good),
            fmt::format(
                "{0} holds {1} machines without a swing that {2} does not, {2} holds {3} that {0} does not",
                name(is_second_good), std::max(for_first, for_second), name(!is_second_good),
                std::min(for_first, for_second))};
    }
    if (std::abs(a - b) > SAME_MARGIN) {
        return {
            of(b > a),
            fmt::format(
                "{0} and {1} hold as many machines, within chance, but 95 of 100 machines leave a margin of "
                "{2:.2f} with {0}, {3:.2f} with {1}",
                name(b > a), name(b <= a), std::max(a, b), std::min(a, b))};
    }
    return {std::nullopt, fmt::format("{} and {} do as well on these machines, within chance",
                                      name(false), name(true))};
}

// The first that no other beats. In a circle, of which chance is the cause, the one that was named
// first.
std::size_t best_of(const Campaign &campaign, const std::vector<Summary> &all,
                    const std::vector<std::size_t> &possible)
{
    const auto is_unbeaten = [&](std::size_t one) {
        return std::none_of(possible.begin(), possible.end(), [&](std::size_t other) {
            return other != one && compare(campaign, all, one, other).better == other;
        });
    };
    const auto found = std::find_if(possible.begin(), possible.end(), is_unbeaten);
    return found == possible.end() ? possible.front() : *found;
}

// One sentence for each of the others.
std::string reason_for(const Campaign &campaign, const std::vector<Summary> &all,
                       const std::vector<std::size_t> &possible, std::size_t best)
{
    std::vector<std::string> sentences;
    for (const std::size_t other : possible) {
        if (other != best) {
            const Comparison found = compare(campaign, all, best, other);
            const bool is_by_order = !found.better && best < other;
            sentences.push_back(
                found.why + (is_by_order ? ", and " + all[best].tuning + " was named first" : ""));
        }
    }
    return sentences.empty() ? "it is the only one that was tried"
                             : fmt::format("{}", fmt::join(sentences, "; "));
}

void choose(const Campaign &campaign, Judgement &judgement)
{
    const std::vector<Summary> &all = judgement.summaries;
    std::vector<std::size_t> possible;
    for (std::size_t k = 0; k < all.size(); k++) {
        if (all[k].refusal.empty()) {
            possible.push_back(k);
        }
    }
    judgement.best = best_of(campaign, all, possible);
    judgement.why = reason_for(campaign, all, possible, judgement.best);
}

std::optional<std::size_t> limiting_of(const Campaign &campaign, const Summary &best)
{
    for (const Influence &influence : best.outstanding()) {
        if (influence.effect() >= SAME_MARGIN && !campaign.box[influence.axis].better.empty()) {
            return influence.axis;
        }
    }
    return std::nullopt;
}

Bound bound_on(const Campaign &campaign, const Trials &trials, std::size_t axis)
{
    Bound bound{axis, campaign.box[axis].high, 0};
    for (std::size_t run = 0; run < trials.size(); run++) {
        if (!is_held(trials[run])) {
            bound.up_to = std::min(bound.up_to, campaign.points[run][axis]);
        }
    }
    for (const Point &point : campaign.points) {
        bound.runs += point[axis] < bound.up_to ? 1 : 0;
    }
    return bound;
}

// Of the loads that stand out, the one below which most machines are.
std::optional<Bound> bound_of(const Campaign &campaign, const Judgement &judgement)
{
    constexpr int least_runs = 10;
    const Summary &best = judgement.summaries[judgement.best];
    std::optional<Bound> found;
    for (const Influence &influence : best.outstanding()) {
        const bool is_load = campaign.box[influence.axis].key.rfind("load.", 0) == 0;
        if (!is_load || best.locked == best.runs) {
            continue;
        }
        const Bound bound =
            bound_on(campaign, campaign.series[judgement.best].trials, influence.axis);
        if (bound.runs >= (found ? found->runs + 1 : least_runs)) {
            found = bound;
        }
    }
    return found;
}

} // namespace

double Influence::effect() const
{
    return *std::max_element(margin.begin(), margin.end()) -
           *std::min_element(margin.begin(), margin.end());
}

double share_by_chance(int runs)
{
    constexpr double most = 13.9; // of chi squared with 3 degrees of freedom: once in 330 times
    constexpr double mean = 3;
    return std::max(LEAST_SHARE, (most - mean) / runs);
}

std::vector<Influence> Summary::outstanding() const
{
    std::vector<Influence> found;
    std::copy_if(influences.begin(), influences.end(), std::back_inserter(found),
                 [&](const Influence &one) { return one.share >= share_by_chance(runs); });
    return found;
}

double Summary::least_locked() const
{
    return least_share(locked, runs);
}

Judgement judge(const Campaign &campaign)
{
    Judgement judgement;
    judgement.summaries.reserve(campaign.series.size());
    for (const Series &series : campaign.series) {
        judgement.summaries.push_back(summary_of(campaign, series));
    }
    choose(campaign, judgement);
    judgement.limiting = limiting_of(campaign, judgement.summaries[judgement.best]);
    judgement.bound = bound_of(campaign, judgement);
    return judgement;
}

} // namespace nf::certify
