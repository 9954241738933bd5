// SPDX-License-Identifier: MIT
// The block that nfconfig writes: what the firmware takes of it, what it is known by, and how a bad
// one is told.
#include "block.h"
#include "cfg_rows.h"
#include "files.h"
#include "header.h"
#include "identity.h"

#include <fmt/format.h>

extern "C" {
#include "config_guard.h"
}

#include "testing.h"

#include <cstring>
#include <filesystem>
#include <functional>

#include <unistd.h>

namespace
{

nf::Config esc1(const std::vector<std::string> &set = {})
{
    return nf::load_parts("outrunner_24v", "b_g431b_esc1", "robust_motor_a", {}, set);
}

TEST(a_block_is_good_for_an_image_of_the_same_files)
{
    const nf::Config config = esc1();
    const config_block_t block = nf::make_block(config);
    const config_identity_t image = nf::identity_of(config);
    const drive_cfg_t cfg = nf::build(config);
    TEST_ASSERT_EQUAL(CONFIG_BLOCK_GOOD, config_block_check(&block, &image).fault);
    TEST_ASSERT_EQUAL_MEMORY(&cfg, &block.cfg, sizeof cfg);
    TEST_ASSERT_EQUAL_UINT32(7, block.about.pole_pairs);
    TEST_ASSERT_EQUAL_INT32(5000, block.about.speed_max_rpm);
    TEST_ASSERT_EQUAL_STRING("neurofoc: 24 V outrunner, example, B-G431B-ESC1, robust for motor A",
                             block.about.name);
}

TEST(a_shipped_motor_is_an_example_and_a_users_file_is_not)
{
    TEST_ASSERT_EQUAL_UINT32(1, nf::make_block(esc1()).about.is_example);
    namespace fs = std::filesystem;
    const fs::path own = fs::temp_directory_path() / fmt::format("mine.{}.toml", getpid());
    fs::copy_file(nf::data_folder() / "motors/outrunner_24v.toml", own,
                  fs::copy_options::overwrite_existing);
    const nf::Config config = nf::load_parts(own.string(), "b_g431b_esc1", nf::DEFAULT_TUNING);
    fs::remove(own);
    TEST_ASSERT_EQUAL_UINT32(0, nf::make_block(config).about.is_example);
}

// What an image has compiled in is what nfconfig makes blocks for.
TEST(the_header_of_an_image_has_the_identity_of_the_blocks)
{
    const config_identity_t identity = nf::identity_of(esc1());
    const std::string line = fmt::format(".identity = {{.schema = 0x{:08X}U, .board = 0x{:08X}U}}",
                                         identity.schema, identity.board);
    TEST_ASSERT_TRUE(nf::make_header(esc1()).find(line) != std::string::npos);
}

TEST(another_motor_or_tuning_is_for_the_same_image)
{
    const config_identity_t image = nf::identity_of(esc1());
    const config_identity_t other =
        nf::identity_of(nf::load_parts("odrive_d5065", "b_g431b_esc1", "any"));
    TEST_ASSERT_EQUAL_HEX32(image.schema, other.schema);
    TEST_ASSERT_EQUAL_HEX32(image.board, other.board);
}

TEST(a_fact_of_the_board_that_is_compiled_into_an_image_makes_it_another_board)
{
    const std::uint32_t image = nf::identity_of(esc1()).board;
    for (const char *set :
         {"board.name=\"another\"", "board.dead_time_s=0.9e-6", "board.trip_a=38",
          "board.pwm_frequency_hz=19000", "board.current_full_scale_a=60.3",
          "board.bus_full_scale_v=34.3", "hal.adc_sampling_ns=140", "hal.amplifier_zero_v=2.1"}) {
        TEST_ASSERT_NOT_EQUAL_MESSAGE(image, nf::identity_of(esc1({set})).board, set);
    }
}

TEST(a_limit_of_the_board_that_the_drive_is_told_is_no_other_board)
{
    const config_identity_t image = nf::identity_of(esc1());
    const config_block_t block = nf::make_block(esc1({"board.bus_min_v=9"}));
    TEST_ASSERT_EQUAL_HEX32(image.board, block.identity.board);
}

TEST(boards_without_a_binding_are_told_apart_too)
{
    const auto board = [](const char *name) {
        return nf::identity_of(nf::load_parts("motor_a", name, "robust_motor_a")).board;
    };
    TEST_ASSERT_NOT_EQUAL(board("bench_310v"), board("g431_bench"));
}

TEST(a_block_refuses_what_the_binding_of_its_board_refuses)
{
    try {
        (void)nf::make_block(esc1({"board.trip_a=0"}));
        TEST_FAIL_MESSAGE("was not refused");
    } catch (const nf::ConfigError &error) {
        TEST_ASSERT_NOT_NULL(std::strstr(error.what(), "board.trip_a"));
    }
}

TEST(what_was_written_is_read)
{
    const config_block_t block = nf::make_block(esc1());
    const config_block_t read = nf::parse_block("x.nfb", nf::block_bytes(block));
    TEST_ASSERT_EQUAL_MEMORY(&block, &read, sizeof block);
}

// After a change; the CRC is right again.
std::string resealed(config_block_t block)
{
    const std::uint32_t version = block.version;
    const std::uint32_t words = block.words;
    const std::uint32_t magic = block.magic;
    const config_identity_t identity = block.identity;
    block.cfg.crc = config_guard_crc(&block.cfg);
    const config_about_t about = block.about;
    const drive_cfg_t cfg = block.cfg;
    config_block_make(&block, &identity, &about, &cfg);
    block.version = version;
    block.words = words;
    block.magic = magic;
    return nf::block_bytes(block);
}

void assert_told(const std::string &bytes, const std::string &line)
{
    try {
        (void)nf::parse_block("x.nfb", bytes);
        TEST_FAIL_MESSAGE("was not refused");
    } catch (const nf::ConfigError &error) {
        TEST_ASSERT_EQUAL_STRING(("x.nfb: " + line).c_str(), error.what());
    }
}

TEST(each_way_to_be_no_good_block_is_told_with_what_was_found_and_expected)
{
    const config_block_t good = nf::make_block(esc1());
    const auto changed = [&](const std::function<void(config_block_t &)> &change) {
        config_block_t block = good;
        change(block);
        return resealed(block);
    };
    assert_told("",
                fmt::format("the file's length: found 0 bytes, expected {}", CONFIG_BLOCK_BYTES));
    assert_told(
        changed([](config_block_t &b) { b.magic = 0x1234; }),
        "this is no configuration block, the magic word: found 0x00001234, expected 0x4243464E");
    assert_told(changed([](config_block_t &b) { b.version = 7; }),
                "the version of its layout: found 7, expected 2");
    assert_told(changed([](config_block_t &b) { b.words = 9; }),
                fmt::format("the length that it says it has in words: found 9, expected {}",
                            CONFIG_BLOCK_WORDS));
    assert_told(
        changed([](config_block_t &b) { b.identity.schema = 5; }),
        fmt::format("it is for a firmware with other settings, the schema: found 0x00000005, "
                    "expected 0x{:08X}",
                    nf::schema_hash()));
    assert_told(changed([](config_block_t &b) { b.cfg.slow_ticks = 5; }),
                "slow_ticks = 5: the firmware does not take this value");
    assert_told(changed([](config_block_t &b) { b.about.pole_pairs = 0; }),
                "about.pole_pairs: the firmware does not take this value");
    config_block_t damaged = good;
    damaged.crc ^= 1;
    assert_told(nf::block_bytes(damaged),
                fmt::format("the block is damaged, its CRC: found 0x{:08X}, expected 0x{:08X}",
                            damaged.crc, good.crc));
}

// The schema has to tell what a block means: settings of other names, places or units are another
// one.
TEST(the_schema_is_not_that_of_the_length_alone)
{
    TEST_ASSERT_NOT_EQUAL(0, nf::schema_hash());
    TEST_ASSERT_NOT_EQUAL(sizeof(drive_cfg_t), nf::schema_hash());
}

TEST(a_description_has_each_setting_with_its_value)
{
    const config_block_t block = nf::make_block(esc1());
    const std::string text = nf::describe_block(block);
    for (const nf::CfgRow &row : nf::cfg_rows()) {
        const std::string line =
            fmt::format("\n{:39}{:>12}\n", row.path, nf::raw_value(row, block.cfg));
        TEST_ASSERT_TRUE_MESSAGE(text.find(line) != std::string::npos, row.path);
    }
    TEST_ASSERT_TRUE(text.find(block.about.name) != std::string::npos);
}

} // namespace
