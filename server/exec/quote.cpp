// Quotes text of a client for an error message or a log line.
#include "server/exec/quote.h"

#include <fmt/format.h>

namespace sightline::server::exec {

std::string quote(std::string_view text) {
  std::string out = "\"";
  for (const char c : text.substr(0, kMaxQuoted)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c >= ' ' && c <= '~' ? c : '?';
  }
  out += '"';
  if (text.size() > kMaxQuoted) out += fmt::format("... ({} bytes)", text.size());
  return out;
}

}  // namespace sightline::server::exec
