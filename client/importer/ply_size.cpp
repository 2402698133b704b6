// Walks over the elements without reading anything but the lengths of lists.
#include "client/importer/ply_size.h"

#include <cstddef>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace sightline::client::importer {
namespace {

struct Property {
  std::size_t bytes = 0;         // of a value
  std::size_t length_bytes = 0;  // of the length of a list; 0: one value
};

struct Element {
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  bool is_big_endian = false;
  std::vector<Element> elements;
  std::size_t end = 0;  // where the elements begin
};

std::size_t bytes_of(const std::string& type) {
  constexpr std::pair<const char*, std::size_t> kTypes[] = {
      {"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},  {"short", 2}, {"ushort", 2},
      {"int16", 2}, {"uint16", 2},  {"int", 4},    {"uint", 4},   {"int32", 4}, {"uint32", 4},
      {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
  for (const auto& [name, bytes] : kTypes) {
    if (type == name) return bytes;
  }
  return 0;
}

std::optional<Property> read_property(std::istringstream& words) {
  std::string type, length;
  words >> type;
  Property property{bytes_of(type), 0};
  if (type == "list") {
    words >> length >> type;
    property = {bytes_of(type), bytes_of(length)};
    if (property.length_bytes == 0) return {};
  }
  if (property.bytes == 0) return {};
  return property;
}

std::optional<Header> read_header(std::string_view file) {
  Header header;
  bool is_binary = false;
  for (std::size_t at = 0; at < file.size();) {
    const std::size_t end = file.find('\n', at);
    if (end == std::string_view::npos) return {};
    std::istringstream words{std::string(file.substr(at, end - at))};
    at = end + 1;
    std::string keyword, word;
    words >> keyword;
    if (keyword == "format") {
      words >> word;
      is_binary = word.starts_with("binary");
      header.is_big_endian = word == "binary_big_endian";
    } else if (keyword == "element") {
      Element element;
      if (!(words >> word >> element.count)) return {};
      header.elements.push_back(std::move(element));
    } else if (keyword == "property") {
      const auto property = read_property(words);
      if (!property || header.elements.empty()) return {};
      header.elements.back().properties.push_back(*property);
    } else if (keyword == "end_header") {
      header.end = at;
      return is_binary ? std::optional(std::move(header)) : std::nullopt;
    }
  }
  return {};
}

std::uint64_t read_length(std::string_view bytes, bool is_big_endian) {
  if (bytes.size() == 1) return static_cast<std::uint8_t>(bytes[0]);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const std::size_t k = is_big_endian ? i : bytes.size() - 1 - i;
    value = value << 8U | static_cast<std::uint8_t>(bytes[k]);
  }
  return value;
}

/// A position in the file that may lie beyond its end.
class Walk {
 public:
  Walk(std::string_view file, std::size_t at) : file_(file), at_(at) {}

  void skip(std::uint64_t count, std::uint64_t bytes) {
    std::uint64_t size = 0, end = 0;
    const bool fits =
        !__builtin_mul_overflow(count, bytes, &size) && !__builtin_add_overflow(at_, size, &end);
    at_ = fits ? end : std::numeric_limits<std::uint64_t>::max();
  }
  bool is_inside() const { return at_ <= file_.size(); }
  std::uint64_t missing() const { return is_inside() ? 0 : at_ - file_.size(); }

  void skip(const Property& property, bool is_big_endian) {
    std::uint64_t count = 1;
    if (property.length_bytes > 0) {
      const std::string_view length =
          is_inside() ? file_.substr(at_, property.length_bytes) : std::string_view();
      skip(1, property.length_bytes);
      count = read_length(length, is_big_endian);
    }
    skip(count, property.bytes);
  }

 private:
  std::string_view file_;
  std::uint64_t at_;
};

// Bytes of an element without lists; nothing if it has one.
std::optional<std::uint64_t> fixed_size(const Element& element) {
  std::uint64_t bytes = 0;
  for (const Property& property : element.properties) {
    if (property.length_bytes > 0) return {};
    bytes += property.bytes;
  }
  return bytes;
}

}  // namespace

std::uint64_t bytes_missing_in_ply(std::string_view file) {
  const auto header = read_header(file);
  if (!header) return 0;
  Walk walk(file, header->end);
  for (const Element& element : header->elements) {
    if (const auto bytes = fixed_size(element)) {
      walk.skip(element.count, *bytes);
      continue;
    }
    for (std::uint64_t i = 0; i < element.count && walk.is_inside(); ++i) {
      for (const Property& property : element.properties)
        walk.skip(property, header->is_big_endian);
    }
  }
  return walk.missing();
}

}  // namespace sightline::client::importer
