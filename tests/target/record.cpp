// SPDX-License-Identifier: MIT
// Records a run of the simulator for the replay on targets:
//
//     record FOLDER SCENARIO [identify] [IMPERFECTION | SECTION.KEY=VALUE]...
//
// writes FOLDER/frames.nfr, what the drive was given, and FOLDER/results.nfr, what it made of it,
// tick by tick from the first one on (hal/mps2/recording.h). With `identify` the drive measures the
// scenario's motor instead of running it. Exit status: 0, or 2 with a line on stderr.
#include "measure.h"
#include "scenario.h"

extern "C" {
#include "recording.h"
}

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace
{

constexpr int RECORDED = 0;
constexpr int BAD_INPUT = 2;

class Recorder : public nf::TickSink
{
public:
    void add(const nf::Tick &tick) override
    {
        add(*tick.sim);
    }

    void add(const nf::Simulation &sim)
    {
        recording_put_frame(grow(frames_, RECORDING_FRAME_BYTES), &sim.in());
        recording_put_result(grow(results_, RECORDING_RESULT_BYTES), &sim.out(), &sim.drive());
        ticks_++;
    }

    void write(const std::filesystem::path &folder, const drive_cfg_t &cfg) const
    {
        const uint32_t hash = recording_config_hash(&cfg);
        write(folder / "frames.nfr", recording_header(RECORDING_FRAMES, hash, ticks_), frames_);
        write(folder / "results.nfr", recording_header(RECORDING_RESULTS, hash, ticks_), results_);
    }

private:
    static uint8_t *grow(std::vector<uint8_t> &bytes, std::size_t by)
    {
        bytes.resize(bytes.size() + by);
        return bytes.data() + (bytes.size() - by);
    }

    static void write(const std::filesystem::path &path, const recording_header_t &header,
                      const std::vector<uint8_t> &records)
    {
        std::vector<uint8_t> bytes(RECORDING_HEADER_BYTES);
        recording_put_header(bytes.data(), &header);
        bytes.insert(bytes.end(), records.begin(), records.end());
        std::ofstream file(path, std::ios::binary);
        file.write(reinterpret_cast<const char *>(bytes.data()),
                   static_cast<std::streamsize>(bytes.size()));
        file.close();
        if (!file) {
            throw std::runtime_error(path.string() + ": cannot be written");
        }
    }

    std::vector<uint8_t> frames_;
    std::vector<uint8_t> results_;
    uint32_t ticks_ = 0;
};

void run(const nf::Config &config, Recorder &recorder)
{
    nf::RunOptions options;
    options.sink = &recorder;
    (void)nf::run_scenario(config, options);
}

void identify(const nf::Config &config, Recorder &recorder)
{
    nf::Simulation sim(config);
    bool first = true;
    const auto before_tick = [&](const nf::Simulation &ended) {
        if (!first) {
            recorder.add(ended);
        }
        first = false;
    };
    const nf::identify::Measurement found = nf::identify::measure(sim, {}, before_tick);
    recorder.add(sim);
    if (!found.refusal.empty()) {
        throw std::runtime_error(found.refusal);
    }
}

void record(const std::filesystem::path &folder, const std::string &scenario,
            std::vector<std::string> choices)
{
    const auto last = std::remove(choices.begin(), choices.end(), "identify");
    const bool measured = last != choices.end();
    choices.erase(last, choices.end());
    std::vector<std::string> with;
    std::vector<std::string> set;
    for (const std::string &choice : choices) {
        (choice.find('=') == std::string::npos ? with : set).push_back(choice);
    }
    const nf::Config config = nf::load_scenario(scenario, with, set);
    Recorder recorder;
    (measured ? identify : run)(config, recorder);
    std::filesystem::create_directories(folder);
    recorder.write(folder, nf::build(config));
}

} // namespace

int main(int argc, char **argv)
{
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    if (arguments.size() < 2) {
        std::fputs(
            "usage: record FOLDER SCENARIO [identify] [IMPERFECTION | SECTION.KEY=VALUE]...\n",
            stderr);
        return BAD_INPUT;
    }
    try {
        record(arguments[0], arguments[1], {arguments.begin() + 2, arguments.end()});
    } catch (const std::exception &error) {
        std::fprintf(stderr, "record: %s\n", error.what());
        return BAD_INPUT;
    }
    return RECORDED;
}
