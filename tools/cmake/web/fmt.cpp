// SPDX-License-Identifier: MIT
// What libfmt.so has on a PC, from the headers.
#include <fmt/format-inl.h>

template auto fmt::detail::dragonbox::to_decimal(float value) noexcept
    -> fmt::detail::dragonbox::decimal_fp<float>;
template auto fmt::detail::dragonbox::to_decimal(double value) noexcept
    -> fmt::detail::dragonbox::decimal_fp<double>;
template auto fmt::detail::thousands_sep_impl<char>(locale_ref) -> thousands_sep_result<char>;
template auto fmt::detail::decimal_point_impl(locale_ref) -> char;
