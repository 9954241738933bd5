// SPDX-License-Identifier: MIT
#include "expression.h"

#include "readable.h"

#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace nf::debug
{
namespace
{

using Combine = double (*)(double, double);

struct Operator {
    std::string_view text;
    Combine combine;
};

double truth(bool value)
{
    return value ? 1.0 : 0.0;
}

} // namespace

bool is_true(double value)
{
    return value < 0.0 || value > 0.0;
}

namespace
{

// What is not known, NaN, is the same as nothing.
bool is_same(double a, double b)
{
    return a <= b && a >= b;
}

// The longer of two that begin alike comes first.
constexpr std::array<Operator, 6> COMPARISONS = {{
    {"==", [](double a, double b) { return truth(is_same(a, b)); }},
    {"!=", [](double a, double b) { return truth(!is_same(a, b)); }},
    {"<=", [](double a, double b) { return truth(a <= b); }},
    {">=", [](double a, double b) { return truth(a >= b); }},
    {"<", [](double a, double b) { return truth(a < b); }},
    {">", [](double a, double b) { return truth(a > b); }},
}};
constexpr std::array<Operator, 2> SUMS = {{
    {"+", [](double a, double b) { return a + b; }},
    {"-", [](double a, double b) { return a - b; }},
}};
constexpr std::array<Operator, 2> PRODUCTS = {{
    {"*", [](double a, double b) { return a * b; }},
    {"/", [](double a, double b) { return a / b; }},
}};
constexpr std::array<Operator, 1> AND = {{
    {"&&", [](double a, double b) { return truth(is_true(a) && is_true(b)); }},
}};
constexpr std::array<Operator, 1> OR = {{
    {"||", [](double a, double b) { return truth(is_true(a) || is_true(b)); }},
}};

constexpr int DEEPEST =
    100; // of parentheses and signs: nobody writes more, and the stack ends somewhere

bool is_name_start(char c)
{
    return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_';
}

// An index is part of a name: out.compare.phase[0].
bool is_name_part(char c)
{
    return is_name_start(c) || std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.' ||
           c == '[' || c == ']';
}

class Parser
{
public:
    Parser(const std::string &text, const Lookup &lookup) : text_(text), lookup_(lookup)
    {
    }

    Value all()
    {
        Value value = either();
        skip_blanks();
        if (at_ < text_.size()) {
            fail(fmt::format("'{}' is not expected here", readable(text_.substr(at_))));
        }
        return value;
    }

private:
    Value either()
    {
        return chain(OR, &Parser::both);
    }
    Value both()
    {
        return chain(AND, &Parser::comparison);
    }
    Value sum()
    {
        return chain(SUMS, &Parser::product);
    }
    Value product()
    {
        return chain(PRODUCTS, &Parser::factor);
    }

    Value comparison()
    {
        Value left = sum();
        if (const Operator *const found = take_one(COMPARISONS)) {
            left = combined(*found, std::move(left), sum());
            if (take_one(COMPARISONS) != nullptr) {
                fail("comparisons do not chain; join them with &&");
            }
        }
        return left;
    }

    template <std::size_t count>
    Value chain(const std::array<Operator, count> &operators, Value (Parser::*operand)())
    {
        Value left = (this->*operand)();
        while (const Operator *const found = take_one(operators)) {
            left = combined(*found, std::move(left), (this->*operand)());
        }
        return left;
    }

    static Value combined(const Operator &op, Value left, Value right)
    {
        return [combine = op.combine, left = std::move(left), right = std::move(right)](
                   const Tick &tick) { return combine(left(tick), right(tick)); };
    }

    Value factor()
    {
        depth_++;
        if (depth_ > DEEPEST) {
            fail("this is nested too deeply");
        }
        Value value = signed_or_plain();
        depth_--;
        return value;
    }

    Value signed_or_plain()
    {
        skip_blanks();
        if (take("!")) {
            return [inner = factor()](const Tick &t) { return truth(is_same(inner(t), 0.0)); };
        }
        if (take("-")) {
            return [inner = factor()](const Tick &t) { return -inner(t); };
        }
        if (take("(")) {
            return closed(either());
        }
        return number_or_name();
    }

    Value closed(Value inner)
    {
        skip_blanks();
        if (!take(")")) {
            fail("a ) is missing");
        }
        return inner;
    }

    Value number_or_name()
    {
        const char c = at_ < text_.size() ? text_[at_] : '\0';
        if (std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.') {
            return number();
        }
        if (is_name_start(c)) {
            return name();
        }
        fail(c == '\0' ? "a value is missing"
                       : fmt::format("'{}' is neither a number nor a name", readable({&c, 1})));
    }

    Value number()
    {
        const char *const start = text_.c_str() + at_;
        char *end = nullptr;
        const double value = std::strtod(start, &end);
        if (end == start || !std::isfinite(value)) {
            fail("this is no number");
        }
        at_ += static_cast<std::size_t>(end - start);
        return [value](const Tick &) { return value; };
    }

    Value name()
    {
        const std::size_t start = at_;
        while (at_ < text_.size() && is_name_part(text_[at_])) {
            at_++;
        }
        const std::string found = text_.substr(start, at_ - start);
        if (found == "abs" && take("(")) {
            return [inner = closed(either())](const Tick &t) { return std::abs(inner(t)); };
        }
        try {
            return lookup_(found);
        } catch (const std::runtime_error &error) {
            at_ = start;
            fail(error.what());
        }
    }

    template <std::size_t count>
    const Operator *take_one(const std::array<Operator, count> &operators)
    {
        skip_blanks();
        for (const Operator &op : operators) {
            if (take(op.text)) {
                return &op;
            }
        }
        return nullptr;
    }

    bool take(std::string_view what)
    {
        if (text_.compare(at_, what.size(), what) != 0) {
            return false;
        }
        at_ += what.size();
        return true;
    }

    void skip_blanks()
    {
        while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) {
            at_++;
        }
    }

    [[noreturn]] void fail(const std::string &why) const
    {
        throw ExpressionError(fmt::format("column {} of '{}': {}", at_ + 1, readable(text_), why));
    }

    const std::string &text_;
    const Lookup &lookup_;
    std::size_t at_ = 0;
    int depth_ = 0;
};

} // namespace

Value parse_expression(const std::string &text, const Lookup &lookup)
{
    return Parser(text, lookup).all();
}

} // namespace nf::debug
