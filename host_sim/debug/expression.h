/* SPDX-License-Identifier: MIT */
// Conditions and sums over signals: speed_rpm > 1000 && state == RUN.
//
//     || && ! == != < <= > >= + - * / ( ) numbers, names, abs(x)
//
// with the usual precedence. A value is a double; true is 1, and whatever is not 0 counts as true.
// What is not known in a run is NaN: neither true nor the same as anything, and no comparison but
// != holds. Comparisons do not chain. Names are the caller's.
#pragma once

#include "tick.h"

#include <functional>
#include <stdexcept>
#include <string>

namespace nf::debug
{

using Value = std::function<double(const Tick &)>;
// The value of a name. Throws std::runtime_error that says what is wrong with it.
using Lookup = std::function<Value(const std::string &name)>;

// what() is a line that names the column, counted from 1.
struct ExpressionError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

bool is_true(double value);

// Throws ExpressionError.
Value parse_expression(const std::string &text, const Lookup &lookup);

} // namespace nf::debug
