// SPDX-License-Identifier: MIT
// nfconfig: shows and checks configurations, and writes them as the header that targets compile and
// as the block that they store.
//
// Exit code 0, or 2 with one line on stderr that says what is wrong.
#include "alike.h"
#include "block.h"
#include "completion.h"
#include "config.h"
#include "data_sheet.h"
#include "describe.h"
#include "files.h"
#include "g4_family.h"
#include "hal_header.h"
#include "header.h"
#include "output_file.h"
#include "program.h"
#include "readable.h"
#include "schema.h"
#include "timed_list.h"
#include "zoo.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <filesystem>
#include <iostream>

namespace
{

struct Choice {
    std::string motor;
    std::string board;
    std::string tuning = nf::DEFAULT_TUNING;
    std::vector<std::string> with;
    std::vector<std::string> set;
    std::string out = "-";
    bool overwrite = false;
    std::string block; // a file to show in place of these
};

void add_choice(CLI::App &command, Choice &choice, bool required = true)
{
    command.add_option("--motor", choice.motor, "Motor, by name or path")
        ->required(required)
        ->type_name(nf::A_MOTOR);
    command.add_option("--board", choice.board, "Board, by name or path")
        ->required(required)
        ->type_name(nf::A_BOARD);
    command.add_option("--tuning", choice.tuning, "Tuning, by name or path")
        ->capture_default_str()
        ->type_name(nf::A_TUNING);
    command.add_option("--with", choice.with, "Imperfection set, by name or path; repeatable")
        ->allow_extra_args(false)
        ->type_name(nf::AN_IMPERFECTION);
    command.add_option("--set", choice.set, "Override section.key=value; repeatable")
        ->allow_extra_args(false)
        ->type_name(nf::A_SETTING);
}

nf::Config load(const Choice &choice)
{
    return nf::load_parts(choice.motor, choice.board, choice.tuning, choice.with, choice.set);
}

// What was accepted and will not do as written.
void print_notes(const nf::Config &config)
{
    for (const std::string &note : config.scenario.notes) {
        std::cerr << "nfconfig: note: " << note << '\n';
    }
}

void write_out(const Choice &choice, const nf::Config &config,
               std::string (*make)(const nf::Config &))
{
    nf::check_output(config, "--out", choice.out);
    nf::write_text(choice.out, make(config));
    print_notes(config);
}

void write_block(const Choice &choice)
{
    if (!choice.overwrite && choice.out != "-" && nf::is_there(choice.out)) {
        throw std::runtime_error(
            fmt::format("{}: is there already; --overwrite replaces it", choice.out));
    }
    write_out(choice, load(choice),
              [](const nf::Config &config) { return nf::block_bytes(nf::make_block(config)); });
}

// Of a block, or of files.
void show(const Choice &choice)
{
    if (!choice.block.empty()) {
        std::cout << nf::describe_block(
            nf::parse_block(choice.block, nf::read_bytes(choice.block)));
        return;
    }
    if (choice.motor.empty() || choice.board.empty()) {
        throw CLI::RequiredError(choice.motor.empty() ? "--motor" : "--board");
    }
    const nf::Config config = load(choice);
    for (const nf::ConfigRow &row : nf::describe(config, nf::build(config))) {
        std::cout << fmt::format("{:39}{:>12}  {:6}{}\n", row.path, row.value,
                                 row.in_run ? "run" : "rest", row.meaning);
    }
    print_notes(config);
}

void list_pins(const std::string &name)
{
    const nf::G4Chip *const chip = nf::find_g4_chip(name);
    if (chip == nullptr) {
        throw std::runtime_error(
            fmt::format("CHIP: found '{}'; allowed: {}", name, nf::g4_chip_names()));
    }
    std::cout << nf::g4_pin_list(*chip);
}

// Of "motor.pole_pairs" "motor".
std::string table_of(const std::string &key)
{
    return key.substr(0, key.find('.'));
}

// Each table once, in the order of the keys.
std::vector<std::string> tables()
{
    std::vector<std::string> names;
    for (const nf::Field &field : nf::schema()) {
        if (names.empty() || names.back() != table_of(field.name())) {
            names.push_back(table_of(field.name()));
        }
    }
    return names;
}

void print_key(const std::string &table, const std::string &name, const std::string &allowed,
               const std::string &by_default, const std::string &meaning)
{
    if (table.empty() || table_of(name) == table) {
        std::cout << fmt::format("{:35} {:35} {:13} {}\n", name, allowed, by_default, meaning);
    }
}

// Of all tables where `table` is empty.
void print_keys(const std::string &table)
{
    std::cout << fmt::format("{:35} {:35} {:13} {}\n", "key", "allowed", "default", "meaning");
    for (const nf::Field &field : nf::schema()) {
        print_key(table, field.name(), field.allowed(), field.default_text(), field.meaning());
    }
    for (const nf::EntryValue &value : nf::entry_values()) {
        print_key(table, value.name(), value.allowed(), "one of them", value.help);
    }
}

void print_conversions()
{
    std::cout
        << "\nfrom a data sheet: x is what it prints, P the pole pairs; in a motor file all is of a "
           "phase in star, and peak\n";
    for (const nf::Conversion &conversion : nf::conversions()) {
        std::cout << fmt::format("{:48}{:24}{}\n", fmt::format("motor.{}", conversion.key),
                                 conversion.formula(), conversion.sheet);
    }
}

void print_keys_and_conversions(const std::string &table)
{
    print_keys(table);
    if (table.empty() || table == "motor") {
        print_conversions();
    }
}

void print_names(const char *kind, const std::vector<std::string> &names)
{
    std::cout << fmt::format("{:14}{}\n", kind, fmt::join(names, " "));
}

void print_lists()
{
    print_names("motors", nf::list_motors());
    print_names("boards", nf::list_boards());
    print_names("tunings", nf::list_tunings());
    print_names("imperfections", nf::list_imperfections());
    std::vector<std::string> ids;
    for (const nf::ScenarioInfo &info : nf::list_scenarios()) {
        ids.push_back(info.id);
    }
    print_names("scenarios", ids);
    print_names("zoo", {nf::zoo::allowed()});
}

// What the zoo has under a name, as files that refer to each other.
void write_zoo(const std::string &name, const std::filesystem::path &folder)
{
    const std::optional<nf::zoo::Reference> found = nf::zoo::parse(name);
    if (!found) {
        nf::fail({"command line", 0}, "motor", '"' + nf::readable(name) + '"', "is not in the zoo",
                 nf::zoo::allowed());
    }
    std::error_code ignored; // a folder that is not there is found by the first file
    std::filesystem::create_directories(folder, ignored);
    for (const nf::zoo::File &file : nf::zoo::files(*found)) {
        nf::write_text((folder / file.name).string(), file.text);
    }
}

// What may be expected of a tuning before the motor has turned, in one line.
void write_alike(const Choice &choice, int count)
{
    constexpr int drawn = 300;
    const nf::Config config = load(choice);
    nf::check_output(config, "--out", choice.out);
    const std::vector<std::string> kin =
        nf::certify::most_alike(choice.motor, choice.board, drawn, count);
    const int held = nf::certify::count_held(kin, choice.tuning);
    nf::write_text(choice.out,
                   fmt::format("{}, {}, tuning {}: holds {} of the {} motors of the zoo that are "
                               "most like it, off their files as a user's is\n",
                               config.motor.name, config.board.name, config.tuning.name, held,
                               kin.size()));
}

// What a hardware binding is made of. `choice` and `chip` hold what is read until the commands run.
void add_hal_commands(CLI::App &app, Choice &choice, std::string &chip)
{
    CLI::App *binding =
        app.add_subcommand("hal-header", "Write the C header of a hardware binding");
    add_choice(*binding, choice);
    binding->add_option("--out", choice.out, "File to write; - is standard output")
        ->capture_default_str();
    binding->callback([&choice] { write_out(choice, load(choice), nf::make_hal_header); });
    CLI::App *pins = app.add_subcommand("pins", "What each pin of an STM32G4 can do for a board");
    pins->add_option("CHIP", chip, "Chip, such as stm32g431cb")->required();
    pins->callback([&chip] { list_pins(chip); });
    CLI::App *memory = app.add_subcommand(
        "hal-memory", "Write the memories of an STM32G4, for the linker script of hal/stm32g4");
    add_choice(*memory, choice);
    memory->add_option("--out", choice.out, "File to write; - is standard output")
        ->capture_default_str();
    memory->callback([&choice] { write_out(choice, load(choice), nf::make_hal_memory); });
}

int run(int argc, char **argv)
{
    Choice choice;
    CLI::App app("Shows and checks configurations, and writes the header that targets compile.",
                 "nfconfig");
    CLI::App *header = app.add_subcommand("header", "Write the C header of a configuration");
    add_choice(*header, choice);
    header->add_option("--out", choice.out, "File to write; - is standard output")
        ->capture_default_str();
    header->callback([&] { write_out(choice, load(choice), nf::make_header); });
    std::string chip;
    add_hal_commands(app, choice, chip);
    CLI::App *block = app.add_subcommand(
        "block", "Write the block of a configuration that an image of its board can store");
    add_choice(*block, choice);
    block->add_option("-o,--out", choice.out, "File to write; - is standard output")->required();
    block->add_flag("--overwrite", choice.overwrite, "Even if the file is there already");
    block->callback([&] { write_block(choice); });
    CLI::App *table = app.add_subcommand(
        "show", "The firmware's numbers and what they mean, or what a block holds");
    add_choice(*table, choice, false);
    table->add_option("BLOCK", choice.block, "The file of a block, in place of motor and board")
        ->excludes("--motor", "--board", "--with", "--set");
    table->callback([&] { show(choice); });
    CLI::App *alike = app.add_subcommand(
        "alike", "How many motors of the zoo that are like it the tuning holds; some seconds");
    add_choice(*alike, choice);
    alike->add_option("--out", choice.out, "File to write; - is standard output")
        ->capture_default_str();
    int count = 20;
    alike->add_option("--count", count, "How many of the zoo's motors to run")
        ->capture_default_str()
        ->check(CLI::Range(1, 300));
    alike->callback([&] { write_alike(choice, count); });
    CLI::App *keys = app.add_subcommand(
        "keys",
        "Every key with range, default and meaning; how to get the motor's from a data sheet");
    std::string table_name;
    keys->add_option("TABLE", table_name, "Only the keys of this table, for instance motor")
        ->check(CLI::IsMember(tables()));
    keys->callback([&] { print_keys_and_conversions(table_name); });
    app.add_subcommand("list", "The files that can be referred to by name")->callback(print_lists);
    CLI::App *drawn = app.add_subcommand(
        "zoo", "Write the files of a motor of the zoo: motor, board, and two scenarios of a run");
    std::string drawn_name;
    std::string folder;
    drawn->add_option("NAME", drawn_name, "For instance zoo:17 or zoo:servo:17@2")->required();
    drawn->add_option("--out", folder, "Folder to write to")->required();
    drawn->callback([&] { write_zoo(drawn_name, folder); });
    if (const std::optional<int> status = nf::parse(app, argc, argv)) {
        return *status;
    }
    return 0;
}

} // namespace

int main(int argc, char **argv)
{
    return nf::guarded("nfconfig", run, argc, argv);
}
