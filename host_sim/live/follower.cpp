// SPDX-License-Identifier: MIT
#include "follower.h"

#include "ends_with.h"
#include "identity.h"
#include "recording.h"

#include <algorithm>
#include <cstring>
#include <utility>

extern "C" {
#include "drive_words.h"
}

#include <fmt/format.h>

namespace nf::live
{
namespace
{

// How long messages are: on a line that spoils one in ten they are short, until it spoils less than
// one in fifty.
constexpr uint8_t STREAM_FULL = 1; // as many entries as fit
constexpr uint8_t STREAM_SHORT = 16;
constexpr uint8_t STATE_SHORT = 8; // words
constexpr double JUDGED_S = 0.25;
constexpr uint64_t BAD_ONE_IN = 10;
constexpr uint64_t GOOD_ONE_IN = 50;

// Ticks that are not shown for so long: a person hears of it from time to time.
constexpr double UNSHOWN_S = 1;
constexpr double SAID_AGAIN_S = 5;

constexpr double S_PER_PS = 1e-12;

// The ring has a segment for the time of so many more, at least: within it the entries have to
// come.
constexpr double COME_WITHIN = RECORDER_SEGMENTS - 1;
constexpr double PINGS_OF_TIMEOUT = 4; // in the time after which the board stops its motor

constexpr int BLOCK_TRIES = 10; // a block that is changed meanwhile is read again

// The board's verdict on a change that is asked for again before a tick has taken it.
constexpr const char *ASK_AGAIN = "ask again";

} // namespace

std::string gap_text(const Gap &gap)
{
    if (gap.until == 0) {
        return fmt::format("ticks from {} on are missing: {}", gap.from, gap.why);
    }
    return fmt::format("ticks {} to {} are missing, in step again at {}: {}", gap.from,
                       gap.until - 1, gap.until, gap.why);
}

Follower::Follower(Channel &channel, TickSink &sink, Reporter reporter,
                   const FollowerOptions &options)
    : reporter_(std::move(reporter)), options_(options), sink_(sink),
      client_(channel, options.timing,
              {reporter_.text, [this](const SegmentInfo &info) { hear(info); },
               [this](const Entries &entries) {
                   if (stream_) {
                       stream_->add(entries);
                   }
               }}),
      shadow_(
          [this](uint32_t crc) {
              const auto found = known_.find(crc);
              return found == known_.end() ? nullptr : &found->second;
          },
          options.keep_s)
{
}

void Follower::refuse_others() const
{
    const auto differs = [](const char *what, uint64_t board, uint64_t here, const char *form) {
        if (board != here) {
            throw LinkError(fmt::format(
                "the board's firmware is another one than this program's: {} {}, here {}. Build "
                "and flash the image of this version, or take the motorsim of the board's",
                what, fmt::format(fmt::runtime(form), board),
                fmt::format(fmt::runtime(form), here)));
        }
    };
    differs("version of the link", identity_.version, LINK_VERSION, "{}");
    differs("schema of the settings", identity_.config.schema, schema_hash(), "{:08x}");
    differs("words of the state", identity_.state_words, drive_words_count(), "{}");
    differs("words of a configuration block", identity_.block_words, CONFIG_BLOCK_WORDS, "{}");
}

void Follower::connect()
{
    connections_++;
    identity_ = client_.hello();
    refuse_others();
    client_.has_rate(identity_.baud);
    (void)block_in_force();
    stream_ = std::make_unique<Stream>(identity_.segment_entries);
    candidate_.reset();
    tried_ = 0;
    if ((identity_.capabilities & LINK_CAN_STREAM) == 0) {
        throw LinkError("the board has no flight recorder: there is nothing to stream");
    }
    begin_stream();
    if (!no_stream_.empty()) {
        (void)client_.line(
            "status"); // in place of what the ticks would show: a fault with its advice
    }
    heard_s_ = client_.now_s();
    shown_s_ = heard_s_;
    overwritten_ = false;
}

// The stream may be at the oldest segment of the ring, and the shadow has those that it has not
// taken.
double Follower::oldest_s() const
{
    constexpr double RINGS = 2;
    return RINGS * RECORDER_SEGMENTS * identity_.segment_entries * identity_.tick_ps * S_PER_PS;
}

// A recording that is kept holds the stream up: it begins when somebody has taken the recording.
void Follower::begin_stream()
{
    const std::string why = client_.stream(careful_ ? STREAM_SHORT : STREAM_FULL);
    if (!why.empty() && why != no_stream_) {
        reporter_.say("no stream: " + why);
    }
    no_stream_ = why;
}

void Follower::judge_line()
{
    const double now_s = client_.now_s();
    if (now_s - judged_s_ < JUDGED_S) {
        return;
    }
    const uint64_t broken = client_.broken() - judged_broken_;
    const uint64_t all = client_.whole() - judged_whole_ + broken;
    judged_s_ = now_s;
    judged_whole_ = client_.whole();
    judged_broken_ = client_.broken();
    const bool was_careful = careful_;
    careful_ = broken * (careful_ ? GOOD_ONE_IN : BAD_ONE_IN) > all;
    if (careful_ != was_careful || !no_stream_.empty()) {
        begin_stream();
    }
}

void Follower::leave()
{
    (void)client_.stream(0);
    client_.bye();
}

recorder_about_t Follower::recorder_about(const config_about_t &about) const
{
    recorder_about_t said{};
    said.tick_ps = identity_.tick_ps;
    said.current_full_scale_ua = identity_.current_full_scale_ua;
    said.bus_full_scale_uv = identity_.bus_full_scale_uv;
    said.pole_pairs = about.pole_pairs;
    static_assert(sizeof said.build == sizeof identity_.build);
    std::memcpy(said.build, identity_.build.data(), sizeof said.build);
    recorder_about_name(&said, about.name);
    return said;
}

void Follower::learn(const config_block_t &block)
{
    const recorder_about_t about = recorder_about(block.about);
    try {
        replay::check_scales(about);
    } catch (const replay::RecordingError &error) {
        throw LinkError(
            fmt::format("the board says of itself what no board can be: {}", error.what()));
    }
    known_.insert({block.cfg.crc, {block.cfg, replay::bases_of(about, block.cfg)}});
}

config_block_t Follower::block_in_force()
{
    const config_identity_t expected = {schema_hash(), identity_.config.board};
    for (int k = 0; k < BLOCK_TRIES; k++) {
        const config_block_t block = client_.read_block();
        if (config_block_check(&block, &expected).fault == CONFIG_BLOCK_GOOD) {
            learn(block);
            take_over(block);
            return block;
        }
    }
    throw LinkError("the configuration block in force is not whole, or no block of this firmware");
}

void Follower::take_over(const config_block_t &block)
{
    about_ = block.about;
    bases_ = known_.at(block.cfg.crc).bases;
    timeout_s_ = block.cfg.link.timeout_ticks * (identity_.tick_ps * S_PER_PS);
}

// Asks the board where it has to.
bool Follower::know(uint32_t crc)
{
    if (known_.count(crc) == 0) {
        (void)block_in_force();
    }
    return known_.count(crc) != 0;
}

std::string Follower::change(const config_block_t &block)
{
    learn(block);
    std::string why = client_.write_block(block);
    for (int k = 0; k < BLOCK_TRIES && debug::ends_with(why, ASK_AGAIN); k++) {
        client_.poll(options_.timing.ring_s);
        why = client_.apply(block.cfg.crc);
    }
    if (why.empty()) {
        take_over(block);
    }
    return why;
}

std::string Follower::defaults()
{
    const std::string why = client_.defaults();
    if (why.empty()) {
        (void)block_in_force();
    }
    return why;
}

void Follower::hear(const SegmentInfo &info)
{
    if (!stream_) {
        return;
    }
    if (stream_->is_overwritten(info.number)) {
        stream_ = std::make_unique<Stream>(identity_.segment_entries); // the board counts anew
        recorders_++;
        candidate_.reset();
        tried_ = 0;
        if (shadow_.is_in_step()) {
            lose("the board's recorder has begun anew");
        }
    }
    stream_->add(info);
    announced_s_ = client_.now_s();
}

void Follower::lose(const std::string &why)
{
    if (gaps_.empty() || gaps_.back().until != 0) {
        gaps_.push_back({shadow_.next(), 0, why});
        reporter_.say(gap_text(gaps_.back()));
    }
    shadow_.lose_step();
    candidate_.reset();
}

void Follower::keep_alive()
{
    const double now_s = client_.now_s();
    const double often_s =
        timeout_s_ > 0 ? std::min(options_.ping_s, timeout_s_ / PINGS_OF_TIMEOUT) : options_.ping_s;
    if (now_s - pinged_s_ < often_s) {
        return;
    }
    pinged_s_ = now_s;
    if (const std::optional<Health> health = client_.ping()) {
        health_ = *health;
    }
    if (client_.whole() != heard_) {
        heard_ = client_.whole();
        heard_s_ = now_s;
    } else if (now_s - heard_s_ > options_.silent_s) {
        reporter_.say("the board does not answer, it is asked who it is");
        if (shadow_.is_in_step()) {
            lose("the board did not answer");
        }
        connect();
    }
}

void Follower::tell_unshown()
{
    const double now_s = client_.now_s();
    if (overwritten_ && now_s - shown_s_ > UNSHOWN_S && now_s - told_s_ > SAID_AGAIN_S) {
        told_s_ = now_s;
        reporter_.say(
            "not in step: the ring of the board is overwritten before its ticks have come; "
            "a higher baud rate or a larger recorder_entries helps");
    }
}

// The newest segment, when the one before is gone: the board keeps its state, but not its entries.
void Follower::choose_candidate()
{
    const bool gone = candidate_ && stream_->has_lost(candidate_->number);
    if (candidate_ && !gone) {
        return;
    }
    overwritten_ = overwritten_ || gone;
    tried_ = candidate_ ? candidate_->number : tried_;
    candidate_ = stream_->newest_after(tried_);
    candidate_s_ = announced_s_;
    state_.clear();
    if (candidate_) {
        stream_->forget_before(candidate_->number);
    }
}

// The board keeps a state that was asked for, but not the entries behind it. Where they come so
// slowly that the ring would overwrite them, they have the line alone.
bool Follower::entries_hurry(const SegmentInfo &segment) const
{
    const double segment_s = S_PER_PS * identity_.segment_entries * identity_.tick_ps;
    const double since_s = client_.now_s() - candidate_s_;
    const double share = stream_->share(segment.number);
    return !state_.empty() && share < 1 && share * COME_WITHIN * segment_s < since_s;
}

// Some words of it. Whether it has asked.
bool Follower::ask_for_state()
{
    choose_candidate();
    if (!candidate_ || entries_hurry(*candidate_)) {
        return false;
    }
    const Client::Piece piece =
        client_.state(candidate_->number, static_cast<uint16_t>(state_.size()),
                      careful_ ? STATE_SHORT : LINK_READ_WORDS_MAX);
    if (!candidate_) {
        return true; // the board has begun anew, and said so before its answer
    }
    const bool refused = piece.answered && piece.words.words.empty();
    state_.insert(state_.end(), piece.words.words.begin(), piece.words.words.end());
    if (refused) {
        overwritten_ = true;
        tried_ = candidate_->number;
        candidate_.reset();
    } else if (state_.size() >= identity_.state_words) {
        const SegmentInfo info = *candidate_;
        candidate_.reset();
        begin(info);
    }
    return true;
}

void Follower::begin(const SegmentInfo &info)
{
    const uint64_t recorder = recorders_;
    const bool known = know(info.config_crc);
    if (recorder != recorders_) {
        return; // the board has begun anew: there is no such segment any more
    }
    const std::string why =
        known ? shadow_.begin(info, state_) : "its configuration is not in force any more";
    tried_ = info.number;
    if (!why.empty()) {
        reporter_.say(fmt::format("segment {} is no begin: {}", info.number, why));
        stream_->forget_up_to(info.number);
        return;
    }
    at_ = info.number;
}

// Not before something is shown again.
void Follower::close_gap(int64_t tick)
{
    if (!gaps_.empty() && gaps_.back().until == 0) {
        gaps_.back().until = tick;
        reporter_.say(gap_text(gaps_.back()));
    }
}

bool Follower::ask_for_missing()
{
    const std::optional<Missing> missing = stream_->missing();
    if (!missing) {
        return false;
    }
    const uint64_t recorder = recorders_;
    const Client::Again again = client_.again(missing->segment, missing->first, missing->count);
    if (again == Client::Again::nothing && recorder == recorders_) {
        stream_->ends_before(*missing);
    }
    return true;
}

void Follower::compute()
{
    while (const std::optional<Stretch> stretch = stream_->take(at_)) {
        const std::optional<uint32_t> unknown = shadow_.unknown_config(*stretch);
        const bool known = !unknown || know(*unknown);
        if (!shadow_.is_in_step()) {
            return; // the board has begun anew meanwhile
        }
        if (!known) {
            lose(fmt::format("the configuration {:08x} was not in force long enough to be read",
                             *unknown));
            return;
        }
        const int64_t first = shadow_.next();
        const Shadow::Advance advance = shadow_.advance(*stretch, sink_);
        if (advance.verdict != Shadow::Verdict::right) {
            departures_ += advance.verdict == Shadow::Verdict::departs ? 1 : 0;
            lose(advance.why);
            return;
        }
        close_gap(first);
        shown_s_ = client_.now_s();
        overwritten_ = false;
        at_ = stretch->end.number;
    }
    if (stream_->is_lost(at_)) {
        overwritten_ = true;
        lose("the line was too slow or too bad");
    }
}

void Follower::step(double wait_s)
{
    keep_alive();
    judge_line();
    bool asked = ask_for_missing();
    if (!shadow_.is_in_step()) {
        asked = ask_for_state() || asked;
        tell_unshown();
    }
    client_.poll(asked ? 0 : wait_s);
    if (shadow_.is_in_step()) {
        compute();
    }
}

} // namespace nf::live
