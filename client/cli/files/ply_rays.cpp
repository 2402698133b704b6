// Reads the header, then finds the columns.
#include "client/cli/files/ply_rays.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "client/cli/flags.h"
#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

struct Property {
  std::string_view name;
  std::string_view type;
};

struct PlyHeader {
  std::string_view format;
  std::optional<std::uint64_t> vertices;
  std::vector<Property> properties;
};

std::string_view next_text_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::string_view next_word(std::string_view& text) {
  const std::size_t begin = std::min(text.find_first_not_of(" \t\r\n"), text.size());
  const std::size_t end = std::min(text.find_first_of(" \t\r\n", begin), text.size());
  const std::string_view word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

Status read_element(std::string_view line, PlyHeader& header, bool& in_vertices) {
  const std::string_view name = next_word(line), number = next_word(line);
  std::uint64_t count = 0;
  const auto [end, error] = std::from_chars(number.begin(), number.end(), count);
  if (error != std::errc() || end != number.end())
    return local_error(fmt::format("element {} has no number", name));
  in_vertices = name == "vertex";
  if (in_vertices) header.vertices = count;
  // What comes after the vertices is not read.
  if (!header.vertices && count > 0)
    return local_error(fmt::format("element {} comes before the vertices", name));
  return {};
}

Status read_header_line(std::string_view line, PlyHeader& header, bool& in_vertices) {
  const std::string_view key = next_word(line);
  if (key == "format") {
    header.format = next_word(line);
  } else if (key == "element") {
    return read_element(line, header, in_vertices);
  } else if (key == "property" && in_vertices) {
    const std::string_view type = next_word(line), name = next_word(line);
    if (type == "list") return local_error("its vertices have lists");
    header.properties.push_back({name, type});
  }
  return {};
}

// `text` becomes what follows the header.
Result<PlyHeader> read_header(std::string_view& text) {
  if (next_text_line(text) != kPlyMagic)
    return local_error("not a .ply file: it does not begin with ply");
  PlyHeader header;
  bool in_vertices = false;
  while (true) {
    if (text.empty()) return local_error("the header of .ply has no end");
    const std::string_view line = next_text_line(text);
    if (line == "end_header") break;
    if (const Status good = read_header_line(line, header, in_vertices); !good) return good.error();
  }
  if (!header.vertices) return local_error("has no vertices");
  return header;
}

// The place of a property of one of two names among the properties.
std::optional<std::size_t> find_property(const PlyHeader& header, std::string_view name,
                                         std::string_view other) {
  for (std::size_t i = 0; i < header.properties.size(); ++i) {
    if (header.properties[i].name == name || header.properties[i].name == other) return i;
  }
  return {};
}

// For each column of RayRow its property; nothing for those that are not there.
using FoundColumns = std::array<std::optional<std::size_t>, std::tuple_size_v<RayRow>>;

Result<FoundColumns> find_columns_of_rays(const PlyHeader& header) {
  constexpr std::array<std::string_view, 8> kNames{"ox", "oy", "oz",   "dx",
                                                   "dy", "dz", "tmin", "tmax"};
  constexpr std::array<std::string_view, 8> kOtherNames{"x",  "y",  "z",    "nx",
                                                        "ny", "nz", "tmin", "tmax"};
  FoundColumns found;
  for (std::size_t k = 0; k < 8; ++k) {
    found[k] = find_property(header, kNames[k], kOtherNames[k]);
    if (found[k] || k >= 6) continue;
    return local_error(
        fmt::format("its vertices have no {} or {}: a ray is x y z and nx ny nz, or "
                    "ox oy oz and dx dy dz",
                    kNames[k], kOtherNames[k]));
  }
  if (found[6].has_value() != found[7].has_value())
    return local_error("tmin and tmax are both there, or neither is");
  return found;
}

Result<FoundColumns> find_columns_of_points(const PlyHeader& header) {
  const RowLayout& layout = layout_of(RowKind::kPoints);
  FoundColumns found;
  for (std::size_t k = 0; k < layout.names.size(); ++k) {
    const auto property = find_property(header, layout.names[k], layout.names[k]);
    if (!property && k < layout.required)
      return local_error(fmt::format("its vertices have no {}", layout.names[k]));
    found[layout.columns[k]] = property;
  }
  return found;
}

Result<RayTable> parse_text(const PlyHeader& header, std::string_view text,
                            const FoundColumns& columns) {
  const std::size_t width = header.properties.size();
  // Each number takes two characters at least.
  if (*header.vertices > text.size() / width) return local_error("cut off");
  const auto values = std::make_shared<std::vector<double>>();
  values->reserve(*header.vertices * width);
  for (std::uint64_t i = 0; i < *header.vertices * width; ++i) {
    const std::string_view word = next_word(text);
    if (word.empty()) return local_error("cut off");
    const auto number = parse_number(word);
    if (!number) {
      return local_error(
          fmt::format("vertex {} has '{}', which is no number", i / width, word.substr(0, 40)));
    }
    values->push_back(*number);
  }
  RayTable table{.shape = {*header.vertices}, .owners = {values}};
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (!columns[k]) continue;
    table.columns[k] = {std::as_bytes(std::span(*values)).data() + *columns[k] * sizeof(double),
                        width * sizeof(double), *scalar_of_ply("double", false)};
  }
  return table;
}

Result<RayTable> parse_binary(const PlyHeader& header, std::span<const std::byte> data,
                              bool swapped, const FoundColumns& columns) {
  std::vector<std::size_t> offsets;
  std::vector<ScalarType> types;
  std::size_t stride = 0;
  for (const Property& property : header.properties) {
    const auto type = scalar_of_ply(property.type, swapped);
    if (!type) {
      return local_error(
          fmt::format("property {} is of the unknown type {}", property.name, property.type));
    }
    offsets.push_back(stride);
    types.push_back(*type);
    stride += type->bytes;
  }
  if (*header.vertices > data.size() / stride) return local_error("cut off");
  RayTable table{.shape = {*header.vertices}};
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (columns[k])
      table.columns[k] = {data.data() + offsets[*columns[k]], stride, types[*columns[k]]};
  }
  return table;
}

}  // namespace

Result<RayTable> parse_ply_rays(std::span<const std::byte> file, RowKind kind) {
  std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  const auto header = read_header(text);
  if (!header) return header.error();
  const auto columns =
      kind == RowKind::kRays ? find_columns_of_rays(*header) : find_columns_of_points(*header);
  if (!columns) return columns.error();
  if (header->format == "ascii") return parse_text(*header, text, *columns);
  const bool swapped = header->format == "binary_big_endian";
  if (!swapped && header->format != "binary_little_endian")
    return local_error(fmt::format("format {} is not known", header->format));
  return parse_binary(*header, file.last(text.size()), swapped, *columns);
}

}  // namespace sightline::client::cli::files
