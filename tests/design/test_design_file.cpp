// SPDX-License-Identifier: MIT
// Design files and published matrices: what they give, and one line for whatever is wrong.
#include "compare.h"
#include "origin.h"
#include "shipped.h"
#include "testing.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <unistd.h>

using namespace test;
namespace fs = std::filesystem;

namespace
{

std::string text_of(const fs::path &path)
{
    std::ifstream stream(path);
    std::stringstream text;
    text << stream.rdbuf();
    return text.str();
}

// A copy of a shipped file with one text replaced, in a folder of its own.
class Spoilt
{
public:
    Spoilt(const fs::path &original, const std::string &old, const std::string &text)
        : folder_(fs::temp_directory_path() / ("design_" + std::to_string(getpid())))
    {
        fs::create_directories(folder_);
        std::string whole = text_of(original);
        const std::size_t place = whole.find(old);
        TEST_ASSERT_TRUE(place != std::string::npos);
        whole.replace(place, old.size(), text);
        std::ofstream(path()) << whole;
    }

    Spoilt(const Spoilt &) = delete;
    Spoilt &operator=(const Spoilt &) = delete;

    ~Spoilt()
    {
        fs::remove_all(folder_);
    }

    std::string path() const
    {
        return (folder_ / "x.toml").string();
    }

private:
    fs::path folder_;
};

template <typename Read> std::string refusal(Read read)
{
    try {
        read();
    } catch (const nf::ConfigError &error) {
        return error.what();
    }
    return "accepted";
}

// The message behind the name of the file.
void expect_refused_design(const char *old, const char *text, const char *message)
{
    const Spoilt file(fs::path(shipped().matrices).parent_path() / "../designs/motor_b.toml", old,
                      text);
    const std::string said = refusal([&] { (void)read_design(file.path()); });
    TEST_ASSERT_EQUAL_STRING(message,
                             said.substr(std::min(said.size(), said.find("x.toml") + 6)).c_str());
}

void expect_refused_matrices(const char *old, const char *text, const char *message)
{
    const Spoilt file(shipped().matrices, old, text);
    const std::string said = refusal([&] { (void)read_matrices(file.path()); });
    TEST_ASSERT_EQUAL_STRING(message,
                             said.substr(std::min(said.size(), said.find("x.toml") + 6)).c_str());
}

TEST(the_shipped_design_is_the_papers)
{
    TEST_ASSERT_EQUAL_STRING("motor B (paper B, section 4)", shipped().inputs.motor.name.c_str());
    TEST_ASSERT_EQUAL_DOUBLE(5, shipped().optimum.cost.q2);
    TEST_ASSERT_EQUAL_INT(SPEED, shipped().optimum.cost.state);
    TEST_ASSERT_EQUAL_INT(LOAD, shipped().optimum.cost.input);
    TEST_ASSERT_EQUAL_DOUBLE(0.264, shipped().published.kp);
}

TEST(overrides_reach_the_design_and_the_motor)
{
    const DesignSettings s = read_design(
        "motor_b", {"optimum.state=integral", "optimum.input=speed", "optimum.horizon_samples=60",
                    "nominal.sample_time_s=0.005", "motor.resistance_ohm=0.5", "start.kp=0.2"});
    TEST_ASSERT_EQUAL_INT(INTEGRAL, s.optimum.cost.state);
    TEST_ASSERT_EQUAL_INT(SUPPLY, s.optimum.cost.input);
    TEST_ASSERT_EQUAL_INT(60, s.optimum.cost.horizon_samples);
    TEST_ASSERT_EQUAL_DOUBLE(0.005, s.nominal.sample_time_s);
    TEST_ASSERT_EQUAL_DOUBLE(0.5, s.inputs.motor.resistance_ohm);
    TEST_ASSERT_EQUAL_DOUBLE(0.2, s.optimum.start.kp);
    TEST_ASSERT_EQUAL_DOUBLE(2.125,
                             read_design("motor_b", {"motor=motor_a"}).inputs.motor.resistance_ohm);
}

TEST(a_design_without_published_matrices_has_one_model)
{
    TEST_ASSERT_EQUAL_INT(1, make_models(read_design("motor_b", {"matrices=\"\""})).size());
}

TEST(wrong_designs_get_one_line)
{
    expect_refused_design("voltage_v = 200", "voltage_v = 2e5",
                          ":8: nominal.voltage_v = 200000: is too large; allowed: 0.1 to 10000 V");
    expect_refused_design(
        "voltage_v = 200", "voltage = 200",
        ":8: nominal.voltage = 200: unknown key, did you mean nominal.voltage_v?");
    expect_refused_design("voltage_v = 200", "",
                          ":1: nominal.voltage_v: is missing; allowed: 0.1 to 10000 V");
    expect_refused_design("horizon_samples = 30", "horizon_samples = 30.5",
                          ":20: optimum.horizon_samples = 30.5: is a number with a fraction; "
                          "allowed: a whole number, 1 to 1000");
    expect_refused_design(
        "\"speed\" ", "\"torque\" ",
        ":21: optimum.state = \"torque\": is no choice; allowed: \"i_q\", \"i_d\", "
        "\"speed\", \"angle\", \"integral\"");
    expect_refused_design("motor = \"motor_b\"", "",
                          ":1: motor: is missing; allowed: the name or path "
                          "of a motor file");
    expect_refused_design(
        "motor = \"motor_b\"", "motor = 3",
        ":3: motor = 3: is a whole number; allowed: a string, the name or path of a "
        "file");
}

TEST(wrong_overrides_get_one_line)
{
    TEST_ASSERT_EQUAL_STRING("--set: \"kp\": is no override; allowed: section.key=value",
                             refusal([] { (void)read_design("motor_b", {"kp"}); }).c_str());
    TEST_ASSERT_EQUAL_STRING(
        "--set: motor.resistance_ohm = 1000: is too large; allowed: 0.001 to 50 Ω",
        refusal([] { (void)read_design("motor_b", {"motor.resistance_ohm=1000"}); }).c_str());
}

TEST(published_matrices_are_read_with_their_corrections)
{
    const PrintedMatrices m = read_matrices(shipped().matrices);
    TEST_ASSERT_EQUAL_DOUBLE(-27.64, m.model.phi(0, 3));
    TEST_ASSERT_EQUAL_DOUBLE(-4.802e-4, m.model.phi(3, 0));
    TEST_ASSERT_EQUAL_DOUBLE(-1.258e-2, m.model.theta(0, 0));
    TEST_ASSERT_EQUAL_INT(2, m.corrections.size());
    TEST_ASSERT_EQUAL_DOUBLE(-4.802e4, m.corrections[0].printed);
}

TEST(wrong_matrices_get_one_line)
{
    expect_refused_matrices("printed = -4.802e4", "printed = -4.8e4",
                            ":18: correction.printed = -48000: is not the entry of the matrix; "
                            "allowed: -48020");
    expect_refused_matrices("row = 4", "row = 5",
                            ":20: correction.row = 5: is too large; allowed: 1 to 4");
    expect_refused_matrices("column = 1\nprinted = -1.258e2", "column = 3\nprinted = -1.258e2",
                            ":29: correction.column = 3: is too large; allowed: 1 to 2");
    expect_refused_matrices("sample_time_s = 0.01", "", ":1: sample_time_s: is missing");
    expect_refused_matrices("[-1.258e2, -9.714e-1],", "",
                            ":11: theta = [[0.02792, -0.7914], [-0.09203, -0.02743], "
                            "[-0.0004572, -0.0…: has 3 rows; allowed: 4 rows of 2");
}

const Comparison &row_of(const std::vector<Comparison> &rows, const std::string &quantity)
{
    const auto found = std::find_if(rows.begin(), rows.end(),
                                    [&](const Comparison &r) { return r.quantity == quantity; });
    TEST_ASSERT_TRUE(found != rows.end());
    return *found;
}

TEST(the_comparison_shows_print_and_computation_side_by_side)
{
    std::vector<ModelStudy> studies;
    for (const Model &m : make_models(shipped())) {
        studies.push_back(study(shipped(), m));
    }
    const std::vector<Comparison> rows = compare_all(shipped(), studies);
    const Comparison &misprint = row_of(rows, "phi_41");
    TEST_ASSERT_EQUAL_DOUBLE(-4.802e4, *misprint.paper);
    TEST_ASSERT_EQUAL_DOUBLE(-4.802e-4, *misprint.printed);
    TEST_ASSERT_EQUAL_DOUBLE(computed().phi(3, 0), *misprint.computed);
    // J of the print to its three digits; the identity holds whatever the parameters.
    TEST_ASSERT_DOUBLE_WITHIN(0.0005, 0.1078, *row_of(rows, "inertia_implied_kg_m2").printed);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.11, *row_of(rows, "inertia_implied_kg_m2").computed);
    TEST_ASSERT_FALSE(row_of(rows, "cost_optimum").paper.has_value());
    for (const Comparison &row : rows) {
        TEST_ASSERT_TRUE(!row.computed || std::abs(*row.computed) < 1e6);
    }
}

} // namespace
