// Numbers and names as text of a page.
#pragma once

#include <string>
#include <string_view>

namespace sightline::client::load::report {

/// Escapes text for the content and the attributes of HTML and SVG.
std::string escape(std::string_view text);

/// The number with three digits and k, M, G: 1234567 is "1.23 M".
std::string short_number(double value);
/// 0.0123 is "12.3 ms".
std::string duration(double seconds);
/// 12'300'000 is "12.3 MB".
std::string bytes(double count);
/// 0.123 is "12 %"; below 10 % with one digit more.
std::string percent(double share);

}  // namespace sightline::client::load::report
