// Looks at the end of the file, or at its size.
#include "client/importer/completeness.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <utility>

#include "client/importer/extension.h"
#include "client/importer/imported_scene.h"
#include "client/importer/ply_size.h"

namespace sightline::client::importer {
namespace {

using Doubts = std::vector<Warning>;

constexpr std::string_view kWhiteSpace = " \t\r\n";
constexpr std::size_t kShown = 40;  // characters of a line

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kWhiteSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kWhiteSpace) + 1 - first);
}

std::string_view last_line(std::string_view text) {
  return text.substr(text.find_last_of("\r\n") + 1);
}

Doubts doubt(std::string message) { return {{.kind = "cut_off", .message = std::move(message)}}; }

Error cut_off(const std::string& why) { return import_error("the file is cut off: " + why); }

Result<Doubts> check_step(std::string_view bytes) {
  constexpr std::string_view kEnd = "END-ISO-10303-21;";
  if (trimmed(bytes).ends_with(kEnd)) return Doubts{};
  return cut_off(fmt::format("it does not end with {}", kEnd));
}

// The fewest numbers or corners of a statement; 0: another statement.
std::size_t fewest_words(std::string_view keyword) {
  constexpr std::pair<std::string_view, std::size_t> kStatements[] = {
      {"v", 3}, {"vn", 3}, {"vt", 1}, {"f", 3}, {"l", 2}, {"p", 1}};
  for (const auto& [name, words] : kStatements) {
    if (name == keyword) return words;
  }
  return 0;
}

bool is_number(const std::string& word) {
  std::istringstream in(word);
  double number = 0;
  return (in >> number) && in.eof();
}

// A corner is V, V/T, V//N or V/T/N.
bool is_corner(const std::string& word) {
  return !word.empty() && word.back() != '/' && word.back() != '-' && word.front() != '/';
}

bool is_statement(std::string_view line) {
  std::istringstream words{std::string(line)};
  std::string keyword, word;
  words >> keyword;
  const std::size_t fewest = fewest_words(keyword);
  std::size_t count = 0;
  const bool has_corners = keyword == "f" || keyword == "l";
  for (; words >> word; ++count) {
    if (fewest > 0 && !(has_corners ? is_corner(word) : is_number(word))) return false;
  }
  return count >= fewest;
}

// Lines end with an end of line, as a rule. Nothing else in an OBJ file says where it ends.
Result<Doubts> check_obj(std::string_view bytes) {
  const std::string_view line = trimmed(last_line(bytes));
  if (line.empty() || line.front() == '#') return Doubts{};
  if (!is_statement(line)) {
    return cut_off(
        fmt::format("its last line is no whole statement: '{}'", line.substr(0, kShown)));
  }
  return doubt("its last line has no end; the file may be cut off");
}

bool is_ascii_stl(std::string_view bytes) {
  const std::string_view head = bytes.substr(0, 500);
  return trimmed(head).starts_with("solid") && head.find("facet") != std::string_view::npos &&
         head.find('\0') == std::string_view::npos;
}

Result<Doubts> check_stl(std::string_view bytes) {
  std::string line(trimmed(last_line(trimmed(bytes))));
  std::transform(line.begin(), line.end(), line.begin(),
                 [](unsigned char c) { return c < 0x80 ? std::tolower(c) : c; });
  if (line.starts_with("endsolid") || line.starts_with("end solid")) return Doubts{};
  return doubt("it does not end with endsolid; the file may be cut off");
}

Result<Doubts> doubts_of_ply(std::string_view bytes) {
  const std::uint64_t missing = bytes_missing_in_ply(bytes);
  if (missing == 0) return Doubts{};
  return cut_off(fmt::format("its header announces {} more bytes, or more", missing));
}

}  // namespace

Result<Doubts> check_complete(std::string_view name, std::string_view bytes) {
  const std::string extension = extension_of(name);
  if (trimmed(bytes.substr(0, 100)).starts_with("ISO-10303-21")) return check_step(bytes);
  if (bytes.starts_with("ply")) return doubts_of_ply(bytes);
  if (extension == "obj") return check_obj(bytes);
  if (extension == "stl" && is_ascii_stl(bytes)) return check_stl(bytes);
  return Doubts{};
}

}  // namespace sightline::client::importer
