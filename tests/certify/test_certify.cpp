// SPDX-License-Identifier: MIT
// A certificate: the box, the draws, the runs, and what is made of them.
#include "alike.h"
#include "campaign.h"
#include "certificate_json.h"
#include "certificate_page.h"
#include "certificate_text.h"
#include "judge.h"
#include "scenario.h"
#include "timetable.h"
#include "worst_map.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "testing.h"

namespace
{

using namespace nf::certify;

constexpr double EXACT = 1e-9;
const std::vector<std::string> MOTOR_A = {"motor=motor_a"};

nf::Config motor_a()
{
    return nf::load_scenario("any", {}, MOTOR_A);
}

const Axis *axis_of(const std::vector<Axis> &box, const std::string &key)
{
    const auto found =
        std::find_if(box.begin(), box.end(), [&](const Axis &axis) { return axis.key == key; });
    return found == box.end() ? nullptr : &*found;
}

const Axis &needed_axis(const std::vector<Axis> &box, const char *key)
{
    const Axis *axis = axis_of(box, key);
    TEST_ASSERT_NOT_NULL_MESSAGE(axis, key);
    return *axis;
}

void expect_range(double low, double high, const Axis &axis)
{
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(EXACT, low, axis.low, axis.key.c_str());
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(EXACT, high, axis.high, axis.key.c_str());
}

void expect_says(const char *words, const std::string &text)
{
    TEST_ASSERT_TRUE_MESSAGE(text.find(words) != std::string::npos, text.c_str());
}

// --- The motors of the zoo that are like it ---

TEST(test_a_motor_of_the_zoo_is_most_like_itself)
{
    for (const char *name : {"zoo:3", "zoo:17"}) {
        const auto alike = most_alike(name, name, 20, 2);
        TEST_ASSERT_EQUAL_UINT(2, alike.size());
        TEST_ASSERT_EQUAL_STRING((name + std::string(":user")).c_str(), alike[0].c_str());
        TEST_ASSERT_TRUE(alike[0] != alike[1]);
    }
}

TEST(test_a_tuning_that_loses_or_cannot_be_computed_does_not_hold)
{
    const std::vector<std::string> servos = {"zoo:servo:1:user", "zoo:servo:2:user"};
    TEST_ASSERT_EQUAL_INT(2, count_held(servos, nf::DEFAULT_TUNING));
    TEST_ASSERT_EQUAL_INT(0, count_held(servos, "published"));
}

// --- The box ---

TEST(test_without_measured_the_box_is_that_of_a_data_sheet)
{
    const std::vector<Axis> box = box_of(motor_a());
    expect_range(0.9 * 2.125, 1.1 * 2.125, needed_axis(box, "motor.resistance_ohm"));
    for (const Axis &axis : box) {
        TEST_ASSERT_TRUE(axis.ground != Ground::measured);
        TEST_ASSERT_TRUE_MESSAGE(axis.low < axis.high, axis.key.c_str());
        TEST_ASSERT_EQUAL(axis.ground == Ground::operation, axis.better.empty());
    }
}

TEST(test_an_error_bar_is_the_range)
{
    nf::Config config = motor_a();
    config.measured.flux_linkage_std_pct = 0.3;
    config.measured.flux_linkage_bound_pct = 0.8;
    config.measured.gain_mismatch_pct = 1.5;
    config.measured.gain_mismatch_bar_pct = 0.2;
    const std::vector<Axis> box = box_of(config);
    const Axis &flux = needed_axis(box, "motor.flux_linkage_wb");
    TEST_ASSERT_TRUE(flux.ground == Ground::measured);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 387e-3 * 2 * std::hypot(0.6, 0.8) / 100,
                              (flux.high - flux.low) / 1e3);
    expect_range(1.3, 1.7, needed_axis(box, "measured.gain_mismatch_pct"));
    TEST_ASSERT_TRUE(needed_axis(box, "motor.inertia_kg_m2").ground == Ground::typical);
}

TEST(test_a_bar_wider_than_its_value_leaves_a_value_above_0)
{
    nf::Config config = motor_a();
    config.measured.resistance_std_pct = 500;
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0.2125,
                              needed_axis(box_of(config), "motor.resistance_ohm").low);
}

TEST(test_what_is_not_there_has_no_axis)
{
    nf::Config config = motor_a();
    config.plant.dead_time_s = 0;
    config.model.dead_time_s = 0;
    config.motor.viscous_friction_nm_s = 0;
    const std::vector<Axis> box = box_of(config);
    TEST_ASSERT_NULL(axis_of(box, "board.dead_time_s"));
    TEST_ASSERT_NULL(axis_of(box, "board.output_capacitance_f"));
    TEST_ASSERT_NULL(axis_of(box, "motor.viscous_friction_nm_s"));
}

// What a leg loses has the device drop in it, which the plant has as a drop.
TEST(test_a_measured_dead_time_is_that_of_the_leg_less_its_drop)
{
    nf::Config config = motor_a();
    config.measured.dead_time_s = 2e-6;
    config.measured.dead_time_bar_s = 1e-7;
    config.plant.device_drop_v = 1.55; // 0.5 µs of 310 V at 10 kHz
    expect_range(1.4, 1.6, needed_axis(box_of(config), "measured.dead_time_s"));
}

// The drive believes all of the loss as dead time, the plant has the drop apart: in the middle both
// lose the same.
TEST(test_in_the_middle_the_legs_lose_what_the_drive_believes)
{
    const nf::Config believed = nf::load_scenario(
        "any", {},
        {"motor=motor_a", "board.dead_time_s=2e-6", "board.device_drop_v=1.2",
         "measured.dead_time_s=2.5e-6", "measured.dead_time_bar_s=1e-7", "measured.bus_v=300"});
    const std::vector<Axis> box = box_of(believed);
    const Axis &dead_time = needed_axis(box, "measured.dead_time_s");
    nf::Config real = believed;
    dead_time.set(real, (dead_time.low + dead_time.high) / 2);
    const auto lost_v = [&](double dead_time_s, double drop_v) {
        return dead_time_s * 300 * believed.board.pwm_frequency_hz + drop_v;
    };
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 1.2, real.plant.device_drop_v);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT,
                              lost_v(believed.model.dead_time_s, believed.model.device_drop_v),
                              lost_v(real.plant.dead_time_s, real.plant.device_drop_v));
}

// Of what an identification has measured, the advice is not to identify it.
TEST(test_the_advice_follows_where_a_range_is_from)
{
    nf::Config config = nf::load_scenario(
        "any", {}, {"motor=motor_a", "board.dead_time_s=2e-6", "board.output_capacitance_f=1e-9"});
    const auto better = [&](const char *key) { return needed_axis(box_of(config), key).better; };
    for (const char *const key :
         {"motor.inertia_kg_m2", "board.dead_time_s", "board.output_capacitance_f"}) {
        expect_says("motorsim identify", better(key));
    }
    config.measured.inertia_std_pct = 1;
    config.measured.viscous_friction_bar_nm_s = 1e-5;
    config.measured.dead_time_s = 2e-6;
    config.measured.dead_time_bar_s = 1e-7;
    config.measured.knee_a = 0.2;
    config.measured.knee_bar_a = 0.05;
    expect_says("steeper ramps", better("motor.inertia_kg_m2"));
    expect_says("higher speed", better("motor.viscous_friction_nm_s"));
    for (const char *const key : {"measured.dead_time_s", "measured.knee_a"}) {
        expect_says("oscilloscope", better(key));
        TEST_ASSERT_TRUE_MESSAGE(better(key).find("motorsim identify") == std::string::npos, key);
    }
    expect_says("drill", better("motor.flux_linkage_wb"));
}

TEST(test_an_axis_changes_the_real_machine)
{
    const nf::Config believed = motor_a();
    const std::vector<Axis> box = box_of(believed);
    nf::Config real = believed;
    real.scenario = timetable(believed, most_inertia(box));
    needed_axis(box, "motor.inductance_d_h").set(real, 10);
    needed_axis(box, "board.bus_gain_pct").set(real, 2);
    needed_axis(box, "board.current_gain_pct").set(real, 1);
    needed_axis(box, "measured.gain_mismatch_pct").set(real, 1);
    needed_axis(box, "load.step_pct").set(real, 50);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0.010, real.motor.inductance_d_h);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, believed.board.bus_full_scale_v / 1.02,
                              real.board.bus_full_scale_v);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 1.5, real.plant.adc_gain_error_pct[0]);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0.5, real.plant.adc_gain_error_pct[1]);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 3.9, real.scenario.load[STEP_LOAD].value);
}

// --- The draws ---

TEST(test_a_draw_lies_in_the_box_and_is_the_same_each_time)
{
    const std::vector<Axis> box = box_of(motor_a());
    for (int run = 0; run < 50; run++) {
        const Point point = draw_point(box, 7, run);
        TEST_ASSERT_TRUE(point == draw_point(box, 7, run));
        TEST_ASSERT_FALSE(point == draw_point(box, 8, run));
        for (std::size_t k = 0; k < box.size(); k++) {
            TEST_ASSERT_TRUE(box[k].low <= point[k] && point[k] <= box[k].high);
        }
    }
}

TEST(test_another_axis_leaves_a_draw_as_it_was)
{
    const std::vector<Axis> box = box_of(motor_a());
    const std::vector<Axis> less(box.begin() + 1, box.end());
    const Point whole = draw_point(box, 1, 3);
    TEST_ASSERT_TRUE(draw_point(less, 1, 3) == Point(whole.begin() + 1, whole.end()));
}

// --- The timetable ---

TEST(test_the_timetable_is_in_order_and_its_windows_are_inside)
{
    const nf::Config config = motor_a();
    const nf::ScenarioSettings scenario = timetable(config, 2 * config.motor.inertia_kg_m2);
    const Windows windows = windows_of(scenario);
    TEST_ASSERT_TRUE(scenario.load[START_LOAD].time_s < scenario.command[0].time_s);
    TEST_ASSERT_TRUE(scenario.command[1].time_s < windows.loaded.from_s);
    TEST_ASSERT_TRUE(scenario.load[STEP_LOAD].time_s < windows.loaded.from_s);
    TEST_ASSERT_TRUE(windows.loaded.to_s <= scenario.command[2].time_s);
    TEST_ASSERT_TRUE(scenario.command[2].time_s < windows.reversed.from_s);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, scenario.duration_s, windows.reversed.to_s);
}

// --- The runs ---

Point middle_of(const std::vector<Axis> &box)
{
    Point point;
    for (const Axis &axis : box) {
        point.push_back((axis.low + axis.high) / 2);
    }
    return point;
}

TEST(test_the_motor_of_the_file_is_held_with_room)
{
    const nf::Config config = motor_a();
    const std::vector<Axis> box = box_of(config);
    const Trial trial = try_point(config, box, middle_of(box), 1);
    TEST_ASSERT_EQUAL_STRING("held", verdict_text(trial.verdict));
    TEST_ASSERT_EQUAL_STRING("", trial.fault.c_str());
    const Margins &margins = trial.margins;
    for (const double margin : {margins.current, margins.speed, margins.angle}) {
        TEST_ASSERT_TRUE(margin > 0.1 && margin < 1);
    }
    TEST_ASSERT_TRUE(trial.worst() <= margins.angle);
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 1, margins.reached);
    TEST_ASSERT_DOUBLE_WITHIN(0.15, 1, margins.highest_rpm / config.motor.rated_speed_rpm);
}

TEST(test_a_machine_of_less_than_half_the_flux_is_not_held)
{
    const nf::Config config = motor_a();
    const std::vector<Axis> box = box_of(config);
    Point point = middle_of(box);
    for (std::size_t k = 0; k < box.size(); k++) {
        point[k] = box[k].key == "motor.flux_linkage_wb" ? point[k] * 0.4 : point[k];
        point[k] = box[k].key == "load.step_pct" ? 100 : point[k];
    }
    const Trial trial = try_point(config, box, point, 1);
    TEST_ASSERT_TRUE(trial.verdict == Verdict::stopped || trial.verdict == Verdict::lost);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0, trial.worst());
}

TEST(test_a_drive_that_believes_the_truth_runs_as_ever)
{
    nf::Config config = motor_a();
    config.scenario.duration_s = 0.5;
    const nf::RunResult one = nf::run_scenario(config);
    const nf::RunResult two = nf::run_scenario(config, config);
    TEST_ASSERT_TRUE(one.metrics.speed_error_rms_rpm == two.metrics.speed_error_rms_rpm);
}

TEST(test_a_drive_that_believes_another_motor_runs_otherwise)
{
    nf::Config real = motor_a();
    real.scenario.duration_s = 0.5;
    nf::Config believed = real;
    believed.motor.inductance_d_h *= 1.2;
    believed.motor.inductance_q_h *= 1.2;
    const nf::RunResult told = nf::run_scenario(real, believed);
    real.plant.inductance_scale = 1 / 1.2;
    real.motor = believed.motor;
    const nf::RunResult scaled = nf::run_scenario(real);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, *scaled.metrics.speed_error_rms_rpm,
                              *told.metrics.speed_error_rms_rpm);
}

// --- The campaign ---

TEST(test_all_tunings_have_the_same_machines)
{
    Campaign campaign = plan({"any", "robust_motor_a"}, {}, MOTOR_A);
    run(campaign, 2, 1);
    TEST_ASSERT_EQUAL(2, campaign.points.size());
    TEST_ASSERT_EQUAL(2, campaign.series[0].trials.size());
    TEST_ASSERT_EQUAL(2, campaign.series[1].trials.size());
    Campaign again = plan({"any", "robust_motor_a"}, {}, MOTOR_A);
    run(again, 2, 1);
    TEST_ASSERT_EQUAL_STRING(json_of(campaign, judge(campaign)).c_str(),
                             json_of(again, judge(again)).c_str());
}

TEST(test_it_stops_between_two_runs)
{
    Campaign campaign = plan({"any"}, {}, MOTOR_A);
    int asked = 0;
    std::vector<double> progress;
    run(campaign, 100, 1,
        {[&](double done) { progress.push_back(done); }, [&] { return ++asked > 2; }});
    TEST_ASSERT_EQUAL(2, campaign.points.size());
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0.01, progress[1]);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 1, progress.back());
    const std::string text = text_of(campaign, judge(campaign));
    expect_says("It was stopped after 2 of 100 runs.", text);
}

// --- The judgement, of runs that are made up ---

Axis axis(const char *key, const char *better)
{
    return {key, key, "", 0, 1, Ground::typical, better, {}};
}

Trial trial(double margin, bool swings = false)
{
    Trial made;
    made.verdict = margin > 0 ? Verdict::held : Verdict::stopped;
    made.fault = margin > 0 ? "" : "OVERCURRENT";
    made.margins.current = margin;
    made.margins.speed = 1;
    made.margins.angle = 1;
    made.swings = swings;
    return made;
}

constexpr int MADE_UP = 200;

// The worst margin falls with the load, to nothing above `most`; R does nothing.
Campaign made_up(const std::vector<std::string> &tunings, const char *matters, double most)
{
    Campaign campaign;
    campaign.box = {axis("motor.resistance_ohm", "Measure R."), axis(matters, "Measure it.")};
    campaign.planned = MADE_UP;
    for (int k = 0; k < MADE_UP; k++) {
        campaign.points.push_back({(k * 37 % MADE_UP) / double(MADE_UP), k / double(MADE_UP)});
    }
    for (const std::string &tuning : tunings) {
        Series series;
        series.tuning = tuning;
        series.believed.motor.rated_speed_rpm = 1000;
        for (const Point &point : campaign.points) {
            series.trials.push_back(trial(point[1] < most ? 1 - point[1] : -0.1));
        }
        campaign.series.push_back(series);
    }
    return campaign;
}

TEST(test_the_value_that_the_margin_depends_on_is_found)
{
    const Campaign campaign = made_up({"one"}, "motor.flux_linkage_wb", 2);
    const Judgement judgement = judge(campaign);
    TEST_ASSERT_EQUAL(1, judgement.limiting.value_or(9));
    TEST_ASSERT_FALSE(judgement.bound.has_value());
    const Summary &summary = judgement.summaries[0];
    TEST_ASSERT_EQUAL_INT(MADE_UP, summary.locked);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 1 / double(MADE_UP), summary.worst.least);
    TEST_ASSERT_TRUE(summary.influences[0].share > 0.9);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.875, summary.influences[0].margin[0]);
    TEST_ASSERT_EQUAL(1, summary.outstanding().size());
}

TEST(test_where_the_margin_hardly_changes_nothing_limits)
{
    Campaign campaign = made_up({"one"}, "motor.flux_linkage_wb", 2);
    for (std::size_t run = 0; run < campaign.points.size(); run++) {
        campaign.series[0].trials[run] = trial(0.5 + 0.01 * campaign.points[run][1]);
    }
    TEST_ASSERT_FALSE(judge(campaign).limiting.has_value());
}

TEST(test_a_load_that_makes_runs_fail_has_a_bound)
{
    Campaign campaign = made_up({"one"}, "load.step_pct", 0.6);
    campaign.box[1].better = "";
    const Judgement judgement = judge(campaign);
    TEST_ASSERT_TRUE(judgement.bound.has_value());
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0.6, judgement.bound->up_to);
    TEST_ASSERT_EQUAL_INT(120, judgement.bound->runs);
    TEST_ASSERT_EQUAL_INT(80, judgement.summaries[0].stopped);
    TEST_ASSERT_EQUAL_INT(80, judgement.summaries[0].faults.at("OVERCURRENT"));
    expect_says("All 120 machines where the load.step_pct is below 0.6 ",
                text_of(campaign, judgement));
    TEST_ASSERT_FALSE(judgement.limiting.has_value());
}

TEST(test_a_tuning_that_swings_is_not_taken)
{
    Campaign campaign = made_up({"one", "two"}, "motor.flux_linkage_wb", 2);
    for (Trial &made : campaign.series[0].trials) {
        made.swings = true;
    }
    TEST_ASSERT_EQUAL(1, judge(campaign).best);
}

void give_room(Series &series)
{
    for (Trial &made : series.trials) {
        made.margins.current = 0.5 + made.margins.current / 2;
    }
}

TEST(test_of_two_that_hold_the_same_the_one_with_more_room_is_taken)
{
    Campaign campaign = made_up({"one", "two"}, "motor.flux_linkage_wb", 2);
    give_room(campaign.series[1]);
    TEST_ASSERT_EQUAL(1, judge(campaign).best);
    std::swap(campaign.series[0].trials, campaign.series[1].trials);
    TEST_ASSERT_EQUAL(0, judge(campaign).best);
}

// 120, 160 and 160 of 200 machines; the third leaves more room.
TEST(test_of_three_the_best_is_compared_with_each_other_one)
{
    Campaign campaign = made_up({"one", "two", "three"}, "motor.flux_linkage_wb", 0.8);
    campaign.series[0].trials = made_up({"one"}, "motor.flux_linkage_wb", 0.6).series[0].trials;
    const Judgement alike = judge(campaign);
    TEST_ASSERT_EQUAL(1, alike.best);
    TEST_ASSERT_EQUAL_STRING(
        "two holds 40 machines without a swing that one does not, one holds 0 that two does not; "
        "two and three do as well on these machines, within chance, and two was named first",
        alike.why.c_str());
    std::swap(campaign.series[0].trials, campaign.series[2].trials);
    TEST_ASSERT_EQUAL(0, judge(campaign).best);
    TEST_ASSERT_EQUAL_STRING(
        "one and two do as well on these machines, within chance, and one was named first; one "
        "holds 40 machines without a swing that three does not, three holds 0 that one does not",
        judge(campaign).why.c_str());
}

// One machine more is chance; then the margin decides, and the words say no more than that.
TEST(test_counts_that_differ_by_chance_are_not_said_to_be_the_same)
{
    Campaign campaign = made_up({"one", "two"}, "motor.flux_linkage_wb", 2);
    give_room(campaign.series[1]);
    campaign.series[1].trials[0] = trial(-0.1);
    const Judgement judgement = judge(campaign);
    TEST_ASSERT_EQUAL(1, judgement.best);
    TEST_ASSERT_EQUAL_size_t(
        0, judgement.why.find("two and one hold as many machines, within chance, but 95 of 100 "));
}

TEST(test_a_tuning_that_is_refused_is_said_and_not_taken)
{
    Campaign campaign = made_up({"one", "two"}, "motor.flux_linkage_wb", 2);
    campaign.series[0].refusal = "it does not fit";
    campaign.series[0].trials.clear();
    const Judgement judgement = judge(campaign);
    TEST_ASSERT_EQUAL(1, judgement.best);
    expect_says("refused: it does not fit", text_of(campaign, judgement));
    expect_says("refused: it does not fit", page_of(campaign, judgement));
}

// --- Map and page ---

TEST(test_each_run_is_in_a_cell_of_the_map)
{
    const Campaign campaign = made_up({"one"}, "load.step_pct", 0.6);
    const Judgement judgement = judge(campaign);
    const WorstMap map = map_of(campaign, judgement);
    TEST_ASSERT_EQUAL(1, map.across);
    int runs = 0;
    int failed = 0;
    for (const Cell &cell : map.cells) {
        runs += cell.runs;
        failed += cell.failed;
    }
    TEST_ASSERT_EQUAL_INT(MADE_UP, runs);
    TEST_ASSERT_EQUAL_INT(80, failed);
    TEST_ASSERT_DOUBLE_WITHIN(EXACT, 0, map.at(map.side - 1, 0).worst);
    TEST_ASSERT_TRUE(map.at(0, 0).worst > 0.8);
}

TEST(test_the_page_asks_for_nothing_elsewhere_and_keeps_names_as_text)
{
    Campaign campaign = made_up({"one"}, "load.step_pct", 0.6);
    campaign.series[0].believed.motor.name = "<script>&";
    const std::string page = page_of(campaign, judge(campaign));
    for (const char *const elsewhere : {"http", "src=", "href=", "@import", "url(", "<script"}) {
        TEST_ASSERT_NULL_MESSAGE(std::strstr(page.c_str(), elsewhere), elsewhere);
    }
    expect_says("&lt;script&gt;&amp;", page);
    expect_says("prefers-color-scheme: dark", page);
    TEST_ASSERT_NOT_NULL(std::strstr(page.c_str(), "class=\"fail\""));
}

} // namespace
