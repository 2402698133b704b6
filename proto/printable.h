// Text from outside, before it goes into a header, a status or a line of the log.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace sightline {

/// Whether a character is ASCII and no control character. gRPC takes no other byte in a header that
/// is not binary, and ends the process that hands it one: ask before every AddMetadata() of text
/// from outside.
constexpr bool is_printable(char c) { return c >= ' ' && c <= '~'; }
constexpr bool is_printable(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return is_printable(c); });
}

/// Whether a text is printable, not empty, and without blanks.
constexpr bool is_visible(std::string_view text) {
  return !text.empty() && is_printable(text) && text.find(' ') == std::string_view::npos;
}

/// The text, with '?' for each byte that is not printable.
inline std::string printable(std::string_view text) {
  std::string shown(text);
  std::replace_if(shown.begin(), shown.end(), [](char c) { return !is_printable(c); }, '?');
  return shown;
}

/// The text, with '?' for each control character: one line, that does nothing to a terminal.
inline std::string one_line(std::string_view text) {
  std::string shown(text);
  std::replace_if(shown.begin(), shown.end(),
                  [](unsigned char c) { return c < ' ' || c == '\x7f'; }, '?');
  return shown;
}

}  // namespace sightline
