// SPDX-License-Identifier: MIT
// Whatever the bytes are, the reader accepts them or refuses them with one line; it never crashes.
#include "files.h"
#include "read_layer.h"

#include "testing.h"

#include <random>

namespace
{

constexpr unsigned MUTANTS = 300; // of each file
const nf::FileKind KINDS[] = {nf::FileKind::motor, nf::FileKind::board, nf::FileKind::tuning,
                              nf::FileKind::scenario, nf::FileKind::imperfection};

void read(nf::FileKind kind, const std::string &text)
{
    try {
        nf::read_layer(kind, "text", text);
    } catch (const nf::ConfigError &error) {
        const std::string line = error.what();
        TEST_ASSERT_EQUAL_STRING("text", line.substr(0, 4).c_str());
        TEST_ASSERT_TRUE(line.find('\n') == std::string::npos);
    }
}

std::vector<std::string> shipped_texts(nf::FileKind kind)
{
    std::vector<std::string> texts;
    for (const std::string &name : nf::list_names(kind)) {
        texts.push_back(nf::read_bytes(nf::resolve(kind, name, "", "", {"test", 0})));
    }
    return texts;
}

// One to four bytes changed, removed, or doubled with what follows them.
std::string mutant(std::string text, std::mt19937 &random)
{
    for (unsigned left = 1 + random() % 4; left > 0 && !text.empty(); left--) {
        const std::size_t at = random() % text.size();
        const std::size_t length = random() % 40;
        switch (random() % 3) {
        case 0:
            text[at] = static_cast<char>(random() % 256);
            break;
        case 1:
            text.erase(at, length);
            break;
        default:
            text.insert(at, text.substr(random() % text.size(), length));
            break;
        }
    }
    return text;
}

TEST(mutants_of_shipped_files_are_read_or_refused)
{
    std::mt19937 random(1); // NOLINT: the same mutants in each run
    for (const nf::FileKind kind : KINDS) {
        for (const std::string &text : shipped_texts(kind)) {
            read(kind, text);
            for (unsigned n = 0; n < MUTANTS; n++) {
                read(kind, mutant(text, random));
            }
        }
    }
}

std::string repeated(const std::string &part, std::size_t times)
{
    std::string text;
    for (std::size_t n = 0; n < times; n++) {
        text += part;
    }
    return text;
}

TEST(nesting_without_end_is_refused)
{
    constexpr std::size_t deep = 100000;
    read(nf::FileKind::motor, repeated("a.", deep) + "a = 1");
    read(nf::FileKind::motor, "[" + repeated("a.", deep) + "a]");
    read(nf::FileKind::motor, "a = " + repeated("[", deep));
    read(nf::FileKind::motor, "a = " + repeated("{a=", deep));
    read(nf::FileKind::motor, "a = " + repeated("[\n{" + repeated("a.", 60) + "a = ", deep / 100));
    read(nf::FileKind::motor, repeated("\"", deep));
    read(nf::FileKind::motor, repeated("x", deep) + " = 1");
    read(nf::FileKind::motor, std::string(deep, '\0'));
    read(nf::FileKind::motor, "");
    read(nf::FileKind::motor, "\xEF\xBB\xBF");
    read(nf::FileKind::motor, "\xFF\xFE\x80");
}

} // namespace
