// SPDX-License-Identifier: MIT
// The calls of the bench without a browser: each one that the page makes is there, a run by calls
// has the figures of a plain run, and whatever is given, the answer is a value or one line.
#include "calls.h"
#include "report.h"
#include "scenario.h"
#include "testing.h"
#include "worker_line.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>

#include <fmt/format.h>

static double clock_s;

// The line that a page would open: nobody answers there, and waiting takes no time.
namespace nf::web
{

std::vector<uint8_t> WorkerLine::read(double wait_s)
{
    clock_s += wait_s;
    return {};
}

void WorkerLine::write(const std::vector<uint8_t> &bytes)
{
    (void)bytes;
}

double WorkerLine::now_s() const
{
    return clock_s;
}

bool WorkerLine::take_stop()
{
    return false;
}

} // namespace nf::web

namespace
{

using nf::web::Json;

Json answer(const std::string &name, const Json &given)
{
    return Json::parse(nf::web::answer(name, given.dump()));
}

Json value(const std::string &name, const Json &given)
{
    const Json said = answer(name, given);
    TEST_ASSERT_TRUE_MESSAGE(said.contains("value"), (name + ": " + said.dump()).c_str());
    return said.at("value");
}

// All matches of the pattern's group in the sources of the page.
std::set<std::string> of_the_page(const std::regex &pattern)
{
    std::set<std::string> found;
    for (const auto &entry : std::filesystem::recursive_directory_iterator(NF_PAGE)) {
        if (entry.is_regular_file()) {
            std::ifstream file(entry.path());
            const std::string text((std::istreambuf_iterator<char>(file)), {});
            for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at) {
                found.insert((*at)[1]);
            }
        }
    }
    return found;
}

std::set<std::string> calls_of_the_page()
{
    std::set<std::string> names =
        of_the_page(std::regex(R"re(call(?:WithFile)?(?:<.*>)?\("([a-z]+\.[a-z]+)")re"));
    for (const std::string &act : of_the_page(std::regex(R"re(\{ call: "([a-z]+)")re"))) {
        names.insert("play." + act);
    }
    return names;
}

std::set<std::string> names_of_all_calls()
{
    std::set<std::string> names;
    for (const nf::web::Calls *calls : nf::web::all_calls()) {
        for (const nf::web::Call &call : *calls) {
            names.insert(call.name);
        }
    }
    return names;
}

TEST(each_call_of_the_page_is_there)
{
    const std::set<std::string> names = calls_of_the_page();
    for (const char *known : {"config.schema", "run.start", "play.start", "play.break",
                              "step.execute", "replay.open", "live.open"}) {
        TEST_ASSERT_EQUAL_MESSAGE(1, names.count(known), known);
    }
    const std::set<std::string> there = names_of_all_calls();
    for (const std::string &name : names) {
        TEST_ASSERT_EQUAL_MESSAGE(1, there.count(name), name.c_str());
    }
    TEST_ASSERT_EQUAL_STRING(R"({"error":"there is no call run.begin"})",
                             nf::web::answer("run.begin", "{}").c_str());
}

TEST(a_run_in_slices_has_the_figures_of_a_plain_run)
{
    const Json given = {{"scenario", "s1"},
                        {"with", {"adc"}},
                        {"set", {"motor.inertia_kg_m2=0.003"}},
                        {"signals", {"speed_rpm"}}};
    const auto ticks = value("run.start", given).at("ticks").get<int64_t>();
    TEST_ASSERT_EQUAL_STRING(R"({"error":"the run is not at its end"})",
                             nf::web::answer("run.result", "{}").c_str());
    Json at;
    do {
        at = value("run.advance", {{"ticks", 4999}});
    } while (!at.at("done").get<bool>());
    TEST_ASSERT_EQUAL_INT64(ticks, at.at("tick").get<int64_t>());
    const Json result = value("run.result", {});
    TEST_ASSERT_EQUAL_INT64(ticks, value("run.times", {}).at("count").get<int64_t>());
    const nf::Config config = nf::load_scenario("s1", {"adc"}, {"motor.inertia_kg_m2=0.003"});
    const std::string plain = nf::json_text(config, nf::run_scenario(config));
    TEST_ASSERT_EQUAL_STRING(plain.c_str(), result.at("json").get<std::string>().c_str());
}

TEST(whatever_is_given_the_answer_is_a_value_or_one_line)
{
    const Json wrong[] = {nullptr,
                          1,
                          "\xff\n",
                          {1, 2},
                          {{"scenario", 5}},
                          {{"scenario", "s1"}, {"set", {"motor.resistance_ohm=-1"}}},
                          {{"ticks", "many"}},
                          {{"line", -1}},
                          {{"file", "../../none"}}};
    for (const std::string &name : names_of_all_calls()) {
        for (const Json &given : wrong) {
            const std::string text =
                nf::web::answer(name, given.dump(-1, ' ', false, Json::error_handler_t::replace));
            const Json said = Json::parse(text);
            const bool is_line =
                said.contains("error") && !said.at("error").get<std::string>().empty() &&
                said.at("error").get<std::string>().find('\n') == std::string::npos;
            TEST_ASSERT_TRUE_MESSAGE(said.contains("value") || is_line,
                                     (name + " of " + given.dump() + ": " + text).c_str());
        }
    }
}

TEST(a_refused_value_is_said_as_the_program_says_it)
{
    const Json said =
        answer("run.start", {{"scenario", "s1"}, {"set", {"motor.resistance_ohm=-1"}}});
    std::string expected;
    try {
        (void)nf::load_scenario("s1", {}, {"motor.resistance_ohm=-1"});
    } catch (const std::exception &error) {
        expected = error.what();
    }
    TEST_ASSERT_FALSE(expected.empty());
    TEST_ASSERT_EQUAL_STRING(expected.c_str(), said.at("error").get<std::string>().c_str());
}

} // namespace
