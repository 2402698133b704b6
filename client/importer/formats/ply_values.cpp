// Loads and turns bytes around, or reads words.
#include "client/importer/formats/ply_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace sightline::client::importer::formats {
namespace {

template <class T>
double load(const char* from, bool is_turned) {
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), from, sizeof(T));
  if (is_turned) std::reverse(bytes.begin(), bytes.end());
  return static_cast<double>(std::bit_cast<T>(bytes));
}

double load(PlyType type, const char* from, bool is_turned) {
  switch (type) {
    case PlyType::kInt8:
      return load<std::int8_t>(from, is_turned);
    case PlyType::kUint8:
      return load<std::uint8_t>(from, is_turned);
    case PlyType::kInt16:
      return load<std::int16_t>(from, is_turned);
    case PlyType::kUint16:
      return load<std::uint16_t>(from, is_turned);
    case PlyType::kInt32:
      return load<std::int32_t>(from, is_turned);
    case PlyType::kUint32:
      return load<std::uint32_t>(from, is_turned);
    case PlyType::kFloat32:
      return load<float>(from, is_turned);
    case PlyType::kFloat64:
      return load<double>(from, is_turned);
  }
  return 0;
}

}  // namespace

PlyValues::PlyValues(std::string_view file, const PlyHeader& header)
    : file_(file),
      format_(header.format),
      at_(header.end),
      text_(file, header.end, header.next_line) {}

bool PlyValues::require(std::uint64_t count, std::uint64_t bytes) {
  const std::uint64_t left = file_.size() - at_;
  if (bytes == 0 || count <= left / bytes) return true;
  std::uint64_t needed = 0;
  if (__builtin_mul_overflow(count, bytes, &needed))
    needed = std::numeric_limits<std::uint64_t>::max();
  missing_ = needed - left;
  return false;
}

bool PlyValues::next_word(double& value) {
  const std::string_view word = text_.word();
  if (const auto read = number(word)) {
    value = *read;
    return true;
  }
  bad_ = word.empty() ? "the file is cut off: its header announces more elements"
                      : fmt::format("line {}: {}", text_.line(), not_a_number(word));
  return false;
}

bool PlyValues::next(PlyType type, double& value) {
  if (is_ascii()) return next_word(value);
  const std::size_t bytes = bytes_of(type);
  if (!require(1, bytes)) return false;
  static constexpr bool kIsLittle = std::endian::native == std::endian::little;
  value = load(type, file_.data() + at_, (format_ == PlyFormat::kLittleEndian) != kIsLittle);
  at_ += bytes;
  return true;
}

bool PlyValues::next_length(const PlyProperty& list, std::uint64_t& length) {
  double value = 0;
  if (!next(list.length_type, value)) return false;
  if (!(value >= 0) || value != std::floor(value) || value > 0xFFFFFFFF) {
    bad_ = fmt::format("{}a list '{}' of {} values",
                       is_ascii() ? fmt::format("line {}: ", text_.line())
                                  : "at byte " + std::to_string(at_) + ": ",
                       shown(list.name), value);
    return false;
  }
  length = static_cast<std::uint64_t>(value);
  return is_ascii() || require(length, bytes_of(list.type));
}

bool PlyValues::skip(const PlyProperty& property) {
  std::uint64_t count = 1;
  if (property.is_list && !next_length(property, count)) return false;
  if (is_ascii()) {
    double ignored = 0;
    while (count > 0 && next_word(ignored)) --count;
    return count == 0;
  }
  if (!require(count, bytes_of(property.type))) return false;
  at_ += count * bytes_of(property.type);
  return true;
}

void PlyValues::end_element() {
  if (is_ascii() && long_line_ == 0 && text_.has_word_on_line()) long_line_ = text_.line();
}

bool PlyValues::has(const PlyElement& element) {
  std::uint64_t bytes = 0;
  for (const PlyProperty& property : element.properties) {
    if (is_ascii() || property.is_list) return true;
    bytes += bytes_of(property.type);
  }
  return require(element.count, bytes);
}

Error PlyValues::error() const {
  if (!bad_.empty()) return import_error(bad_);
  return import_error(
      fmt::format("the file is cut off: its header announces {} more bytes, or more", missing_));
}

Result<std::uint64_t> PlyValues::surplus_bytes() {
  const std::size_t end = at();
  const std::string_view rest = trimmed(file_.substr(end));
  if (is_ascii() && !rest.empty() && long_line_ > 0) {
    return import_error(fmt::format(
        "line {} has more values than its element has properties in the header", long_line_));
  }
  return rest.empty() ? 0 : file_.size() - end;
}

}  // namespace sightline::client::importer::formats
