// Decodes percent signs and base64.
#include "client/importer/gltf/uri.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>

#include "client/importer/gltf/refusal.h"

namespace sightline::client::importer::gltf {
namespace {

constexpr std::uint8_t kNoDigit = 0xFF;

constexpr std::array<std::uint8_t, 256> digits() {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::array<std::uint8_t, 256> out{};
  for (std::uint8_t& digit : out) digit = kNoDigit;
  for (std::size_t i = 0; i < kDigits.size(); ++i)
    out[static_cast<std::uint8_t>(kDigits[i])] = static_cast<std::uint8_t>(i);
  return out;
}

std::string decode_base64(std::string_view text, std::string_view where) {
  static constexpr std::array<std::uint8_t, 256> kDigits = digits();
  while (text.ends_with('=')) text.remove_suffix(1);
  std::string out;
  out.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  unsigned count = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::uint8_t digit = kDigits[static_cast<std::uint8_t>(text[i])];
    if (digit == kNoDigit) refuse("{}: character {} of its base64 is no digit", where, i);
    bits = bits << 6U | digit;
    count += 6;
    if (count < 8) continue;
    count -= 8;
    out += static_cast<char>(bits >> count & 0xFFU);
  }
  return out;
}

}  // namespace

bool is_data_uri(std::string_view uri) { return uri.starts_with("data:"); }

std::string decode_data_uri(std::string_view uri, std::string_view where) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) refuse("{}: its data URI has no comma", where);
  const std::string_view data = uri.substr(comma + 1);
  if (!uri.substr(0, comma).ends_with(";base64")) return percent_decoded(data);
  if (data.find('%') == std::string_view::npos) return decode_base64(data, where);
  return decode_base64(percent_decoded(data), where);
}

std::string percent_decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned code = 0;
    const char* const first = text.data() + i + 1;
    const char* const last = first + std::min<std::size_t>(2, text.size() - i - 1);
    const bool is_code =
        text[i] == '%' && last - first == 2 && std::from_chars(first, last, code, 16).ptr == last;
    out += is_code ? static_cast<char>(code) : text[i];
    if (is_code) i += 2;
  }
  return out;
}

}  // namespace sightline::client::importer::gltf
