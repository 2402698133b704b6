// Looks at headers only.
#include "client/importer/preflight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>
#include <string_view>

#include "client/importer/imported_scene.h"

namespace sightline::client::importer {
namespace {

constexpr std::size_t kLongestPlyHeader = std::size_t{1} << 20;

// Whether some word "end_header" starts a line and is followed by a blank or the end.
bool has_end_of_header(std::string_view text) {
  constexpr std::string_view kEnd = "end_header", kBlanks = " \t\r\n";
  for (std::size_t i = text.find(kEnd); i != std::string_view::npos; i = text.find(kEnd, i + 1)) {
    const std::size_t before = text.substr(0, i).find_last_not_of(" \t");
    const bool begins =
        before != std::string_view::npos && kBlanks.find(text[before]) != kBlanks.npos;
    const std::size_t after = i + kEnd.size();
    if (begins && (after == text.size() || kBlanks.find(text[after]) != kBlanks.npos)) return true;
  }
  return false;
}

// The sum of the counts in the header's lines "element NAME COUNT".
std::uint64_t announced(std::istringstream header) {
  std::uint64_t sum = 0;
  for (std::string line; std::getline(header, line) && !line.starts_with("end_header");) {
    std::istringstream words(line);
    std::string keyword, name;
    std::uint64_t count = 0;
    if (words >> keyword >> name >> count && keyword == "element")
      sum += std::min<std::uint64_t>(count, std::uint64_t{1} << 40U);
  }
  return sum;
}

Status check_ply(std::string_view file) {
  const std::string_view text = file.substr(0, kLongestPlyHeader);
  const std::uint64_t size = file.size();
  if (!has_end_of_header(text))
    return import_error(
        fmt::format("a PLY file without end_header in its first {} bytes", text.size()));
  const std::uint64_t elements = announced(std::istringstream(std::string(text)));
  if (elements <= size) return {};
  return import_error(
      fmt::format("the PLY header announces {} elements, the file has {} bytes", elements, size));
}

}  // namespace

Status preflight(std::string_view bytes) {
  return bytes.starts_with("ply") ? check_ply(bytes) : Status();
}

}  // namespace sightline::client::importer
