// Parses and writes the Python literals of .npy headers.
#include "client/cli/files/npy.h"

#include <fmt/format.h>

#include <charconv>
#include <limits>
#include <optional>
#include <utility>

#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

constexpr std::size_t kAlignment = 64;  // the data's, as NumPy aligns it

// Parses a dict literal such as {'descr': '<f8', 'fortran_order': False, 'shape': (3, 4), }.
class DictParser {
 public:
  explicit DictParser(std::string_view text) : rest_(text) {}

  bool accept(char c) {
    skip_space();
    if (!rest_.starts_with(c)) return false;
    rest_.remove_prefix(1);
    return true;
  }

  std::optional<std::string> string() {
    skip_space();
    if (rest_.empty() || (rest_[0] != '\'' && rest_[0] != '"')) return {};
    const std::size_t end = rest_.find(rest_[0], 1);
    if (end == std::string_view::npos) return {};
    std::string text(rest_.substr(1, end - 1));
    rest_.remove_prefix(end + 1);
    return text;
  }

  std::optional<bool> boolean() {
    skip_space();
    for (const auto& [word, value] : {std::pair("True", true), std::pair("False", false)}) {
      if (!rest_.starts_with(word)) continue;
      rest_.remove_prefix(std::string_view(word).size());
      return value;
    }
    return {};
  }

  // Parses (), (3,) or (3, 4).
  std::optional<std::vector<std::uint64_t>> tuple() {
    if (!accept('(')) return {};
    std::vector<std::uint64_t> numbers;
    while (!accept(')')) {
      skip_space();
      std::uint64_t number = 0;
      const auto [end, error] = std::from_chars(rest_.begin(), rest_.end(), number);
      if (error != std::errc()) return {};
      rest_.remove_prefix(static_cast<std::size_t>(end - rest_.begin()));
      numbers.push_back(number);
      if (!accept(',')) {
        if (!accept(')')) return {};
        break;
      }
    }
    return numbers;
  }

  // Parses a string, or returns the text of a list.
  std::optional<std::string> dtype() {
    skip_space();
    if (!rest_.starts_with('[')) return string();
    std::size_t depth = 0;
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      if (rest_[i] == '[') ++depth;
      if (rest_[i] == ']' && --depth == 0) {
        std::string text(rest_.substr(0, i + 1));
        rest_.remove_prefix(i + 1);
        return text;
      }
    }
    return {};
  }

 private:
  void skip_space() {
    while (!rest_.empty() && (rest_[0] == ' ' || rest_[0] == '\n' || rest_[0] == '\t')) {
      rest_.remove_prefix(1);
    }
  }

  std::string_view rest_;
};

std::optional<NpyHeader> parse_dict(std::string_view text) {
  DictParser dict(text);
  std::optional<std::string> dtype;
  std::optional<bool> fortran_order;
  std::optional<std::vector<std::uint64_t>> shape;
  if (!dict.accept('{')) return {};
  while (!dict.accept('}')) {
    const auto key = dict.string();
    if (!key || !dict.accept(':')) return {};
    if (*key == "descr") {
      dtype = dict.dtype();
    } else if (*key == "fortran_order") {
      fortran_order = dict.boolean();
    } else if (*key == "shape") {
      shape = dict.tuple();
    } else {
      return {};
    }
    if (!dict.accept(',')) {
      if (!dict.accept('}')) return {};
      break;
    }
  }
  if (!dtype || !fortran_order || !shape) return {};
  return NpyHeader{std::move(*dtype), *fortran_order, std::move(*shape), 0};
}

std::uint64_t little_endian(std::string_view bytes) {
  std::uint64_t x = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) x = x << 8U | static_cast<unsigned char>(bytes[i]);
  return x;
}

std::string descr_of(std::span<const NpyField> fields) {
  std::string descr;
  for (const NpyField& field : fields)
    descr += fmt::format("('{}', '{}'), ", field.name, field.type);
  if (!descr.empty()) descr.resize(descr.size() - 2);
  return fmt::format("[{}]", descr);
}

std::string dict_of(std::string_view descr, std::span<const std::uint64_t> shape) {
  return fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': ({}{}), }}", descr,
                     fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
}

// The header with this dictionary, which has room for one of `longest` bytes.
std::string header_of(const std::string& dict, std::size_t longest) {
  const std::size_t prefix = kNpyMagic.size() + 2 + 2;
  const std::size_t total = (prefix + longest + 1 + kAlignment - 1) / kAlignment * kAlignment;
  const std::size_t length = total - prefix;
  std::string header(kNpyMagic);
  header += {'\x01', '\x00', static_cast<char>(length & 0xFFU), static_cast<char>(length >> 8U)};
  header += dict;
  header.resize(total - 1, ' ');
  return header + '\n';
}

}  // namespace

Result<NpyHeader> parse_npy_header(std::span<const std::byte> file) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  if (!text.starts_with(kNpyMagic))
    return local_error("not a .npy file: its first bytes are not \\x93NUMPY");
  if (text.size() < 10) return local_error(".npy header is cut off");
  const int version = static_cast<unsigned char>(text[6]);
  if (version < 1 || version > 3)
    return local_error(fmt::format(".npy version {} is not known (1 to 3 are)", version));
  const std::size_t length_bytes = version == 1 ? 2 : 4;
  const std::size_t start = 8 + length_bytes;
  if (text.size() < start) return local_error(".npy header is cut off");
  const std::uint64_t length = little_endian(text.substr(8, length_bytes));
  if (text.size() - start < length) return local_error(".npy header is cut off");
  auto header = parse_dict(text.substr(start, length));
  if (!header) return local_error(".npy header is malformed");
  header->data_offset = start + length;
  return *std::move(header);
}

std::string make_npy_header(std::span<const NpyField> fields, std::uint64_t n) {
  const std::string descr = descr_of(fields);
  const std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  return header_of(dict_of(descr, {&n, 1}), dict_of(descr, {&most, 1}).size());
}

std::string make_npy_header(std::span<const NpyField> fields,
                            std::span<const std::uint64_t> shape) {
  const std::string dict = dict_of(descr_of(fields), shape);
  return header_of(dict, dict.size());
}

std::string make_npy_header(std::string_view type, std::span<const std::uint64_t> shape) {
  const std::string dict = dict_of(fmt::format("'{}'", type), shape);
  return header_of(dict, dict.size());
}

}  // namespace sightline::client::cli::files
