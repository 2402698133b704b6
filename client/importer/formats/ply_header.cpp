// One line after the other, each by its first word.
#include "client/importer/formats/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <unordered_set>
#include <utility>

#include "client/importer/formats/text.h"

namespace sightline::client::importer::formats {
namespace {

constexpr std::size_t kLongest = std::size_t{1} << 20;

struct NamedType {
  std::string_view name, new_name;
  PlyType type;
};
constexpr NamedType kTypes[] = {
    {"char", "int8", PlyType::kInt8},        {"uchar", "uint8", PlyType::kUint8},
    {"short", "int16", PlyType::kInt16},     {"ushort", "uint16", PlyType::kUint16},
    {"int", "int32", PlyType::kInt32},       {"uint", "uint32", PlyType::kUint32},
    {"float", "float32", PlyType::kFloat32}, {"double", "float64", PlyType::kFloat64}};

std::optional<PlyType> type_of(std::string_view word) {
  for (const NamedType& type : kTypes) {
    if (word == type.name || word == type.new_name) return type.type;
  }
  return {};
}

class HeaderReader {
 public:
  explicit HeaderReader(std::string_view file) : file_(file) {
    if (file_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
    const std::size_t end = file_.find_first_of("\r\n", at_);
    const bool is_cr = end != std::string_view::npos && file_[end] == '\r' &&
                       !file_.substr(end).starts_with("\r\n");
    end_of_line_ = is_cr ? '\r' : '\n';
  }

  Result<PlyHeader> read() {
    if (trimmed(next_line()) != "ply") return import_error("a PLY file begins with the line 'ply'");
    while (!is_at_end_) {
      std::string_view line = next_line();
      const std::string_view keyword = take_word(line);
      if (keyword == "end_header" && trimmed(line).empty()) return finish();
      if (const Status good = read_line(keyword, line); !good) {
        return import_error(
            fmt::format("line {} of the PLY header: {}", line_, good.error().message));
      }
    }
    return import_error(fmt::format("a PLY file without end_header in its first {} bytes",
                                    std::min(file_.size(), kLongest)));
  }

 private:
  std::string_view next_line() {
    const std::string_view text = file_.substr(0, kLongest);
    const std::size_t end = std::min(text.find(end_of_line_, at_), text.size());
    const std::string_view line = text.substr(at_, end - at_);
    is_at_end_ = end == text.size();
    at_ = is_at_end_ ? end : end + 1;
    ++line_;
    return trimmed(line);
  }

  Status read_line(std::string_view keyword, std::string_view rest) {
    if (keyword == "format") return read_format(rest);
    if (keyword == "element") return read_element(rest);
    if (keyword == "property") return read_property(rest);
    if (keyword.empty() || keyword == "comment" || keyword == "obj_info") return {};
    if (header_.warnings.empty()) {
      header_.warnings.push_back(
          {"unknown_statements", 1, fmt::format("line {}: {}", line_, shown(keyword)),
           fmt::format("line {} of its header begins with an unknown word, '{}', and is not read",
                       line_, shown(keyword))});
    } else {
      ++header_.warnings[0].count;
    }
    return {};
  }

  Status read_format(std::string_view rest) {
    constexpr std::pair<std::string_view, PlyFormat> kFormats[] = {
        {"ascii", PlyFormat::kAscii},
        {"binary_little_endian", PlyFormat::kLittleEndian},
        {"binary_big_endian", PlyFormat::kBigEndian}};
    const std::string_view word = take_word(rest);
    for (const auto& [name, format] : kFormats) {
      if (word != name) continue;
      header_.format = format;
      has_format_ = true;
      return {};
    }
    return import_error(fmt::format(
        "format '{}', must be ascii, binary_little_endian or binary_big_endian", shown(word)));
  }

  Status read_element(std::string_view rest) {
    PlyElement element;
    element.name = take_word(rest);
    const std::string_view count = take_word(rest);
    const auto value = integer(count);
    if (element.name.empty() || value.value_or(-1) < 0) {
      return import_error(
          fmt::format("element '{}' with the count '{}', must be a name and a number",
                      shown(element.name), shown(count)));
    }
    element.count = static_cast<std::uint64_t>(*value);
    if (!elements_.insert(element.name).second)
      return import_error(fmt::format("a second element '{}'", shown(element.name)));
    announced_ += std::min(element.count, kEnough);
    header_.elements.push_back(std::move(element));
    return {};
  }

  Status read_property(std::string_view rest) {
    if (header_.elements.empty()) return import_error("a property before the first element");
    PlyProperty property;
    std::string_view word = take_word(rest);
    property.is_list = word == "list";
    if (property.is_list) {
      const auto length = type_of(word = take_word(rest));
      if (!length) return unknown_type(word);
      property.length_type = *length;
      word = take_word(rest);
    }
    const auto type = type_of(word);
    if (!type) return unknown_type(word);
    property.type = *type;
    property.name = take_word(rest);
    if (property.name.empty()) return import_error("a property without a name");
    PlyElement& element = header_.elements.back();
    constexpr std::string_view kRead[] = {"x", "y", "z", "vertex_indices", "vertex_index"};
    const bool is_read =
        std::find(std::begin(kRead), std::end(kRead), property.name) != std::end(kRead);
    if (is_read && element.find(property.name) < element.properties.size()) {
      return import_error(fmt::format("a second property '{}' of the element '{}'",
                                      shown(property.name), shown(element.name)));
    }
    element.properties.push_back(std::move(property));
    return {};
  }

  static Error unknown_type(std::string_view word) {
    return import_error(fmt::format("a property of the unknown type '{}'", shown(word)));
  }

  Result<PlyHeader> finish() {
    if (!has_format_) return import_error("the PLY header has no line 'format'");
    if (announced_ > file_.size()) {
      return import_error(fmt::format("the PLY header announces {} elements, the file has {} bytes",
                                      announced_, file_.size()));
    }
    header_.end = at_;
    header_.next_line = line_ + 1;
    return std::move(header_);
  }

  static constexpr std::uint64_t kEnough = std::uint64_t{1} << 40U;  // for any file

  std::string_view file_;
  std::size_t at_ = 0;
  std::uint64_t line_ = 0;
  char end_of_line_ = '\n';
  bool is_at_end_ = false, has_format_ = false;
  std::uint64_t announced_ = 0;
  PlyHeader header_;
  std::unordered_set<std::string> elements_;  // their names
};

}  // namespace

std::size_t bytes_of(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kInt32:
    case PlyType::kUint32:
    case PlyType::kFloat32:
      return 4;
    case PlyType::kFloat64:
      return 8;
  }
  return 0;
}

std::size_t PlyElement::find(std::string_view property) const {
  std::size_t i = 0;
  while (i < properties.size() && properties[i].name != property) ++i;
  return i;
}

Result<PlyHeader> read_ply_header(std::string_view file) { return HeaderReader(file).read(); }

}  // namespace sightline::client::importer::formats
