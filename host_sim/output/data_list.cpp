// SPDX-License-Identifier: MIT
#include "data_list.h"

#include "config.h"
#include "files.h"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>

namespace nf
{
namespace
{

// The comment at the head of a set says what it is.
std::string head_comment(const std::string &name)
{
    std::istringstream file(read_bytes(data_folder() / "imperfections" / (name + ".toml")));
    std::string text;
    std::string line;
    while (std::getline(file, line) && line.rfind("# ", 0) == 0) {
        text += (text.empty() ? "" : " ") + line.substr(2);
    }
    return text;
}

std::string scenario_line(const ScenarioInfo &info, int width)
{
    const Config config = load_scenario(info.id);
    const std::string figure =
        info.paper_figure.empty() ? "" : fmt::format(" ({})", info.paper_figure);
    return fmt::format("  {:<{}}  {}{}\n  {:<{}}  {}, tuning {}\n", info.id, width, info.title,
                       figure, "", width, config.motor.name, config.tuning.name);
}

} // namespace

std::string data_list_text()
{
    const std::vector<ScenarioInfo> scenarios = list_scenarios();
    const std::vector<std::string> sets = list_imperfections();
    std::size_t width = 0;
    for (const ScenarioInfo &info : scenarios) {
        width = std::max(width, info.id.size());
    }
    for (const std::string &name : sets) {
        width = std::max(width, name.size());
    }
    const int column = static_cast<int>(width);
    std::string text = "Scenarios, for `motorsim run NAME`:\n\n";
    for (const ScenarioInfo &info : scenarios) {
        text += scenario_line(info, column);
    }
    text += "\nImperfections, for `--with NAME`; several add up:\n\n";
    for (const std::string &name : sets) {
        text += fmt::format("  {:<{}}  {}\n", name, column, head_comment(name));
    }
    return text;
}

} // namespace nf
