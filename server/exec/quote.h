// Quotes text of a client for an error message or a log line.
#pragma once

#include <string>
#include <string_view>

namespace sightline::server::exec {

inline constexpr std::size_t kMaxQuoted = 96;  ///< Bytes of the text that are shown.

/// The text in double quotes: printable ASCII only (anything else is shown as '?', a quote or
/// backslash is escaped), cut after kMaxQuoted bytes; the full length is then appended.
std::string quote(std::string_view text);

}  // namespace sightline::server::exec
