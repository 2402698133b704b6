// Names are UTF-8, or Latin-1.
#include "client/importer/node_name.h"

#include <cstddef>

#include "client/importer/imported_scene.h"

namespace sightline::client::importer {
namespace {

bool is_continuation(unsigned char c) { return (c & 0xC0U) == 0x80U; }

// The length in bytes of the well-formed character at the front (Unicode table 3-7), 0 if there is
// none.
std::size_t character_length(std::string_view s) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(s[i]); };
  const unsigned char first = at(0);
  if (first < 0x80) return 1;
  if (first < 0xC2 || first > 0xF4) return 0;
  const std::size_t length = first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  if (s.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if (!is_continuation(at(i))) return 0;
  }
  const bool overlong = (first == 0xE0 && at(1) < 0xA0) || (first == 0xF0 && at(1) < 0x90);
  const bool surrogate = first == 0xED && at(1) >= 0xA0;
  const bool beyond = first == 0xF4 && at(1) >= 0x90;
  return overlong || surrogate || beyond ? 0 : length;
}

std::string utf8_from_latin1(std::string_view s) {
  std::string out;
  for (const char raw : s) {
    const auto c = static_cast<unsigned char>(raw);
    if (c < 0x80) {
      out += raw;
    } else {
      out += static_cast<char>(0xC0U | (c >> 6U));
      out += static_cast<char>(0x80U | (c & 0x3FU));
    }
  }
  return out;
}

}  // namespace

bool is_utf8(std::string_view s) {
  while (!s.empty()) {
    const std::size_t length = character_length(s);
    if (length == 0) return false;
    s.remove_prefix(length);
  }
  return true;
}

std::string node_name(std::string_view name, std::string_view suffix) {
  std::string out = is_utf8(name) ? std::string(name) : utf8_from_latin1(name);
  const std::size_t longest = kMaxNodeName - suffix.size();
  if (out.size() > longest) {
    std::size_t end = longest;
    while (end > 0 && is_continuation(static_cast<unsigned char>(out[end]))) --end;
    out.resize(end);
  }
  return out.append(suffix);
}

}  // namespace sightline::client::importer
