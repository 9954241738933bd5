// SPDX-License-Identifier: MIT
#include "convention.h"

#include "readable.h"
#include "spelling.h"

#include <algorithm>

#include <fmt/format.h>

namespace nf::sheet
{
namespace
{

struct Phrase {
    const char *words;
    Convention means;  // nothing: a word that changes nothing
    bool weak = false; // only where no other word says across what
};

constexpr Convention TERMINALS = {Across::terminals, Sort::unsaid};
constexpr Convention PHASE = {Across::phase, Sort::unsaid};
constexpr Convention WINDING = {Across::winding, Sort::unsaid};
constexpr Convention PEAK = {Across::unsaid, Sort::peak};
constexpr Convention RMS = {Across::unsaid, Sort::rms};
constexpr Convention SIX_STEP = {Across::unsaid, Sort::six_step};

// The longest first of those that begin alike. The first of each meaning is the one that is shown.
const std::vector<Phrase> PLACES = {
    {"phase to phase", TERMINALS},
    {"phase to neutral", PHASE},
    {"phase neutral", PHASE},
    {"phase phase", TERMINALS},
    {"line to line", TERMINALS},
    {"line to neutral", PHASE},
    {"line line", TERMINALS},
    {"line neutral", PHASE},
    {"terminal to terminal", TERMINALS},
    {"between two terminals", TERMINALS},
    {"between terminals", TERMINALS},
    {"lead to lead", TERMINALS},
    {"terminal", TERMINALS},
    {"ph to ph", TERMINALS},
    {"ph ph", TERMINALS},
    {"l to l", TERMINALS},
    {"l l", TERMINALS},
    {"ll", TERMINALS},
    {"l to n", PHASE},
    {"l n", PHASE},
    {"ln", PHASE},
    {"per phase", PHASE},
    {"phase", PHASE},
    {"star", PHASE, true},
    {"wye", PHASE, true},
    {"delta winding", WINDING, true},
    {"delta", WINDING, true},
};

const std::vector<Phrase> SINES = {
    {"peak", PEAK}, {"pk", PEAK}, {"amplitude", PEAK}, {"rms", RMS},
    {"eff", RMS},   {"sine", {}}, {"sinusoidal", {}},
};

const std::vector<Phrase> BLOCKS = {
    {"six step", SIX_STEP}, {"sixstep", SIX_STEP},     {"block commutation", SIX_STEP},
    {"block", SIX_STEP},    {"trapezoidal", SIX_STEP}, {"dc", SIX_STEP},
};

// Of a current there is no other place than a phase of the star, the wire to the motor.
const std::vector<Phrase> OF_CURRENT = {{"phase current", {}}, {"phase", {}}, {"current", {}}};

std::vector<Phrase> joined(std::vector<Phrase> all, const std::vector<Phrase> &more)
{
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

std::vector<Phrase> phrases_of(Needs needs)
{
    switch (needs) {
    case Needs::across:
        return PLACES;
    case Needs::sort:
        return joined(SINES, OF_CURRENT);
    case Needs::any_sort:
        return joined(joined(SINES, BLOCKS), OF_CURRENT);
    case Needs::voltage: {
        std::vector<Phrase> all = joined(joined(SINES, BLOCKS), PLACES);
        all.erase(std::remove_if(all.begin(), all.end(),
                                 [](const Phrase &p) { return p.means.across == Across::winding; }),
                  all.end());
        return all;
    }
    case Needs::nothing:
        break;
    }
    return {};
}

// What to write, and what the choice changes.
const char *allowed_words(Needs needs)
{
    switch (needs) {
    case Needs::across:
        return R"("phase to phase", twice the value of a phase, "phase", or "delta winding", three times it)";
    case Needs::sort:
        return R"("peak" or "rms"; peak is 1.414 times rms)";
    case Needs::any_sort:
        return R"("peak", "rms" or "six-step"; for one motor the number per A rms is 1.414 times, that of six-step )"
               R"((block) commutation 1.103 times the one per A peak)";
    case Needs::voltage:
        return R"("peak" or "rms" and "phase to phase" or "phase", or "six-step" alone; the peak of a voltage is )"
               R"(1.414 times its rms, phase to phase 1.732 times phase, six-step 0.955 times peak phase to phase)";
    case Needs::nothing:
        break;
    }
    return "a number with its unit and nothing else";
}

bool begins(const std::vector<std::string> &phrase, const std::vector<std::string> &said,
            std::size_t at)
{
    return phrase.size() <= said.size() - at &&
           std::equal(phrase.begin(), phrase.end(), said.begin() + static_cast<std::ptrdiff_t>(at));
}

template <typename Meaning> bool add(Meaning &known, Meaning more)
{
    const bool agree = more == Meaning::unsaid || known == Meaning::unsaid || known == more;
    known = more == Meaning::unsaid ? known : more;
    return agree;
}

// What words say, before it is asked whether that is enough.
struct Hearing {
    Convention strong;
    Across weak = Across::unsaid;
    bool agrees = true;
    std::string unknown; // the first word that no phrase has

    void hear(const std::vector<Phrase> &phrases, const std::vector<std::string> &said);
    Convention convention() const;
};

void Hearing::hear(const std::vector<Phrase> &phrases, const std::vector<std::string> &said)
{
    for (std::size_t at = 0; at < said.size() && unknown.empty();) {
        const auto found = std::find_if(phrases.begin(), phrases.end(), [&](const Phrase &p) {
            return begins(words_of(p.words), said, at);
        });
        if (found == phrases.end()) {
            unknown = said[at];
            return;
        }
        at += words_of(found->words).size();
        const bool agree =
            found->weak ? add(weak, found->means.across) : add(strong.across, found->means.across);
        agrees = add(strong.sort, found->means.sort) && agree && agrees;
    }
}

Convention Hearing::convention() const
{
    return {strong.across == Across::unsaid ? weak : strong.across, strong.sort};
}

bool is_enough(Needs needs, const Convention &said)
{
    const bool has_sort = said.sort != Sort::unsaid;
    const bool has_place = said.across != Across::unsaid;
    switch (needs) {
    case Needs::across:
        return has_place;
    case Needs::sort:
    case Needs::any_sort:
        return has_sort;
    case Needs::voltage:
        return said.sort == Sort::six_step || (has_sort && has_place);
    case Needs::nothing:
        break;
    }
    return true;
}

} // namespace

std::string words(const Convention &convention)
{
    static const char *const PLACE[] = {"", "phase to phase", "phase", "delta winding"};
    static const char *const SORT[] = {"", "peak", "rms", "six-step"};
    const std::string sort = SORT[static_cast<int>(convention.sort)];
    const std::string place = PLACE[static_cast<int>(convention.across)];
    return sort.empty() || place.empty() ? sort + place : sort + ' ' + place;
}

std::optional<Convention> convention_of(Needs needs, const std::vector<std::string> &said,
                                        std::string &problem)
{
    Hearing heard;
    heard.hear(phrases_of(needs), said);
    const Convention convention = heard.convention();
    // Six steps are between two terminals: more of that says nothing, and of a phase it is wrong. A
    // phase of a triangle is its winding, and none of the star.
    const bool is_torn = convention.across == Across::phase &&
                         (convention.sort == Sort::six_step || heard.weak == Across::winding);
    if (!heard.unknown.empty()) {
        problem = fmt::format("\"{}\" is no word for it; allowed: {}", readable(heard.unknown),
                              allowed_words(needs));
    } else if (!heard.agrees || is_torn) {
        problem = fmt::format("its words contradict each other; allowed: {}", allowed_words(needs));
    } else if (!is_enough(needs, convention)) {
        problem = fmt::format("say {}", allowed_words(needs));
    } else {
        return convention.sort == Sort::six_step ? SIX_STEP : convention;
    }
    return {};
}

std::vector<Convention> conventions_of(Needs needs)
{
    switch (needs) {
    case Needs::across:
        return {TERMINALS, PHASE, WINDING};
    case Needs::sort:
        return {PEAK, RMS};
    case Needs::any_sort:
        return {PEAK, RMS, SIX_STEP};
    case Needs::voltage:
        return {{Across::terminals, Sort::peak},
                {Across::terminals, Sort::rms},
                {Across::phase, Sort::peak},
                {Across::phase, Sort::rms},
                SIX_STEP};
    case Needs::nothing:
        break;
    }
    return {{}};
}

} // namespace nf::sheet
