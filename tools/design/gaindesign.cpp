// SPDX-License-Identifier: MIT
// Command line of the gain design: paper B's optimal speed controller for a motor file.
// Exit status: 0 done, 1 `check` found a pair unstable, 2 wrong usage, wrong file or an unstable
// design.
#include "program.h"
#include "report.h"

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace
{

using namespace nf::design;

constexpr int DONE = 0;
constexpr int UNSTABLE = 1;

constexpr const char *EXAMPLES = R"(Examples:
  gaindesign design                              the gains of paper B's motor, and how they follow
  gaindesign design --json build/design.json     all of it, and what compare shows, for tools/plot.py
  gaindesign design --set optimum.horizon_samples=60 --set optimum.q2=1
  gaindesign design --set motor.resistance_ohm=0.5 --set nominal.inertia_kg_m2=0.2
  gaindesign check 0.264 -0.035                  is this pair of gains stable, and by which pole
  gaindesign compare                             what of the paper can be reproduced

--matrices says whose gains are printed as the drive's: computed from the motor file, or those of the
publication that the design names. A design is a file like tools/design/designs/motor_b.toml. Its keys:

  motor                                   name or path of a motor file
  matrices                                path of published matrices, may be left out
)";

constexpr const char *EXIT_STATUS = R"(
Exit status: 0 done, 1 `check` found the pair unstable, 2 wrong usage or input, or an unstable design.)";

struct Arguments {
    std::string design = "motor_b";
    std::vector<std::string> set;
    std::string matrices = "computed";
    std::string json;
    Gains gains = {0, 0};
};

std::vector<ModelStudy> study_all(const DesignSettings &settings)
{
    std::vector<ModelStudy> studies;
    for (const Model &model : make_models(settings)) {
        studies.push_back(study(settings, model));
    }
    return studies;
}

void require_matrices(const DesignSettings &settings, const std::string &matrices)
{
    if (matrices == "printed" && settings.matrices.empty()) {
        throw std::runtime_error(
            fmt::format("--matrices: printed: {} names no published matrices; allowed: computed",
                        settings.file));
    }
}

int design(const Arguments &arguments)
{
    const DesignSettings settings = read_design(arguments.design, arguments.set);
    nf::check_output(settings.inputs, "--json", arguments.json);
    require_matrices(settings, arguments.matrices);
    const std::vector<ModelStudy> studies = study_all(settings);
    if (arguments.json.empty()) {
        nf::write_text("-", design_text(settings, studies, arguments.matrices));
    } else {
        nf::write_text(arguments.json, design_json(settings, studies, arguments.matrices));
    }
    return DONE;
}

int compare(const Arguments &arguments)
{
    const DesignSettings settings = read_design(arguments.design, arguments.set);
    nf::write_text("-", comparison_text(compare_all(settings, study_all(settings))));
    return DONE;
}

int check(const Arguments &arguments)
{
    check_gains(arguments.gains, "check");
    std::string text;
    bool stable = true;
    for (const Model &model : make_models(read_design(arguments.design, arguments.set))) {
        text += poles_text(model, arguments.gains);
        stable = stable && is_stable(model.discrete, arguments.gains);
    }
    nf::write_text("-", text);
    return stable ? DONE : UNSTABLE;
}

void describe_common(CLI::App &command, Arguments &arguments)
{
    command
        .add_option("--design", arguments.design,
                    "name of a file in tools/design/designs, or path of a .toml")
        ->capture_default_str();
    command.add_option("--set", arguments.set, "override a key; may be repeated")
        ->allow_extra_args(false)
        ->type_name("KEY=VALUE");
}

void describe_design(CLI::App &command, Arguments &arguments)
{
    command
        .add_option("--json", arguments.json,
                    "write JSON in place of the text; - is standard output")
        ->check([](const std::string &name) { return name.empty() ? "needs a file's name" : ""; },
                "")
        ->type_name("FILE");
    command.add_option("--matrices", arguments.matrices, "whose gains the drive gets")
        ->capture_default_str()
        ->check(CLI::IsMember({"computed", "printed"}));
}

int parse_and_do(int argc, char **argv)
{
    CLI::App app{"Designs the speed controller of a phase-compensated drive: paper B, section 3.",
                 "gaindesign"};
    Arguments arguments;
    CLI::App *const design_command =
        app.add_subcommand("design", "stable region, optimal gains, step responses");
    CLI::App *const check_command = app.add_subcommand("check", "the poles of a pair of gains");
    CLI::App *const compare_command =
        app.add_subcommand("compare", "the paper's figures beside what follows from it");
    for (CLI::App *const command : {design_command, check_command, compare_command}) {
        describe_common(*command, arguments);
    }
    describe_design(*design_command, arguments);
    check_command->add_option("kp", arguments.gains.kp, "K_p")->required();
    check_command->add_option("ki", arguments.gains.ki_per_s, "K_i, 1/s")->required();
    app.footer(EXAMPLES + key_list() + EXIT_STATUS);
    if (const std::optional<int> status = nf::parse(app, argc, argv)) {
        return *status;
    }
    if (*design_command) {
        return design(arguments);
    }
    if (*check_command) {
        return check(arguments);
    }
    return compare(arguments);
}

} // namespace

int main(int argc, char **argv)
{
    return nf::guarded("gaindesign", parse_and_do, argc, argv);
}
