// CSV, JSON, NumPy and PLY.
#include "client/cli/files/hit_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "client/cli/files/npy.h"
#include "client/cli/files/zip.h"
#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

std::vector<NpyField> npy_fields(const HitFormatOptions& options) {
  std::vector<NpyField> fields;
  fields.reserve(options.columns.size());
  for (const HitColumn column : options.columns) {
    const HitColumnInfo& info = info_of(column, options.asked);
    fields.push_back({info.name, info.type});
  }
  return fields;
}

/// A name as a value of CSV, on one line and without effect on a terminal.
void add_csv_name(std::string_view name, std::string& bytes) {
  const std::string text = printable(name);
  if (text.find_first_of(",\" ") == std::string::npos) {
    bytes += text;
    return;
  }
  bytes += '"';
  for (const char c : text) bytes += c == '"' ? std::string("\"\"") : std::string(1, c);
  bytes += '"';
}

std::string json_text(std::string_view name) {
  using nlohmann::json;
  return json(name).dump(-1, ' ', false, json::error_handler_t::replace);
}

/// One row after the other, each of the same length.
void add_structured_rows(const std::vector<HitColumn>& columns, const RowView& rows, std::size_t n,
                         std::string& bytes) {
  std::size_t stride = 0;
  for (const HitColumn column : columns) stride += info_of(column).bytes;
  const std::size_t begin = bytes.size();
  bytes.resize(begin + n * stride);
  std::size_t offset = begin;
  for (const HitColumn column : columns) {
    for (std::size_t i = 0; i < n; ++i)
      put_bytes(rows, i, column, bytes.data() + i * stride + offset);
    offset += info_of(column).bytes;
  }
}

class CsvHits : public HitFormat {
 public:
  explicit CsvHits(HitFormatOptions options) : options_(std::move(options)) {}

  std::string header(std::uint64_t) const override {
    std::string names;
    if (!options_.names) return names;
    for (const HitColumn column : options_.columns) {
      if (!names.empty()) names += ',';
      names += info_of(column, options_.asked).name;
    }
    return names + '\n';
  }

  std::size_t add(const RowView& rows, std::size_t n, std::string& bytes) override {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < options_.columns.size(); ++k) {
        if (k > 0) bytes += ',';
        if (options_.columns[k] == HitColumn::kName) {
          add_csv_name(name_of(rows, i), bytes);
        } else {
          put_text(rows, i, options_.columns[k], bytes);
        }
      }
      bytes += '\n';
    }
    return n;
  }

 private:
  HitFormatOptions options_;
};

class JsonHits : public HitFormat {
 public:
  explicit JsonHits(HitFormatOptions options) : options_(std::move(options)) {}

  std::string header(std::uint64_t) const override { return {}; }

  std::size_t add(const RowView& rows, std::size_t n, std::string& bytes) override {
    std::string value;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < options_.columns.size(); ++k) {
        const HitColumn column = options_.columns[k];
        put_value(rows, i, column, value);
        fmt::format_to(std::back_inserter(bytes), "{}\"{}\":{}", k == 0 ? '{' : ',',
                       info_of(column, options_.asked).name, value);
      }
      bytes += "}\n";
    }
    return n;
  }

 private:
  static void put_value(const RowView& rows, std::size_t i, HitColumn column, std::string& value) {
    value.clear();
    if (column == HitColumn::kName) {
      value = json_text(name_of(rows, i));
      return;
    }
    put_text(rows, i, column, value);
    // JSON has no infinity and no NaN.
    if (value == "inf" || value == "-inf" || value == "nan" || value == "-nan") value = "null";
  }

  HitFormatOptions options_;
};

class NpyHits : public HitFormat {
 public:
  explicit NpyHits(HitFormatOptions options) : options_(std::move(options)) {}

  std::string header(std::uint64_t rows) const override {
    const auto fields = npy_fields(options_);
    if (!options_.array_shape.empty()) return make_npy_header(fields, options_.array_shape);
    return make_npy_header(fields, rows);
  }
  bool counts_rows() const override { return options_.array_shape.empty(); }

  std::size_t add(const RowView& rows, std::size_t n, std::string& bytes) override {
    add_structured_rows(options_.columns, rows, n, bytes);
    return n;
  }

 private:
  HitFormatOptions options_;
};

// An array a column. They are kept in memory, because each must be whole before the next begins.
class NpzHits : public HitFormat {
 public:
  explicit NpzHits(HitFormatOptions options)
      : options_(std::move(options)), arrays_(options_.columns.size()) {}

  std::string header(std::uint64_t) const override { return {}; }

  std::size_t add(const RowView& rows, std::size_t n, std::string&) override {
    for (std::size_t k = 0; k < arrays_.size(); ++k)
      add_structured_rows({options_.columns[k]}, rows, n, arrays_[k]);
    rows_ += n;
    return n;
  }

  Result<std::string> finish() override {
    const std::vector<std::uint64_t> shape =
        options_.array_shape.empty() ? std::vector{rows_} : options_.array_shape;
    std::vector<ZipEntry> entries;
    for (std::size_t k = 0; k < arrays_.size(); ++k) {
      const HitColumnInfo& info = info_of(options_.columns[k], options_.asked);
      entries.push_back({std::string(info.name) + ".npy",
                         make_npy_header(info.type, shape) + std::exchange(arrays_[k], {})});
    }
    return zip(entries);
  }

 private:
  HitFormatOptions options_;
  std::vector<std::string> arrays_;
  std::uint64_t rows_ = 0;
};

// A vertex is a hit: its position, and its columns. A miss has no position, and no vertex. For
// points a vertex is the point that was asked, if there is a face.
class PlyHits : public HitFormat {
 public:
  explicit PlyHits(HitFormatOptions options) : options_(std::move(options)) {}

  std::string header(std::uint64_t rows) const override {
    std::string text = fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment {}\n"
        "element vertex {:<20}\nproperty double x\nproperty double y\nproperty double z\n",
        is_of_points() ? "points and what is nearest" : "hits of rays", rows);
    for (const HitColumn column : options_.columns)
      text += fmt::format("property {} {}\n", ply_type(column), property_name(column));
    return text + "end_header\n";
  }
  bool needs_lines() const override { return true; }
  bool counts_rows() const override { return true; }

  std::size_t add(const RowView& rows, std::size_t n, std::string& bytes) override {
    std::size_t added = 0;
    for (std::size_t i = 0; i < n; ++i) {
      if (!std::isfinite(rows.t[i])) continue;
      const auto point = is_of_points() ? asked_point(rows, i) : hit_point(rows, i);
      bytes.append(reinterpret_cast<const char*>(point.data()), sizeof(point));
      for (const HitColumn column : options_.columns) add_value(rows, i, column, bytes);
      ++added;
    }
    return added;
  }

 private:
  bool is_of_points() const { return options_.asked == RowKind::kPoints; }

  // x y z are those of the vertex.
  std::string property_name(HitColumn column) const {
    const std::string name(info_of(column, options_.asked).name);
    return column >= HitColumn::kX && column <= HitColumn::kZ ? "nearest_" + name : name;
  }

  static std::array<double, 3> asked_point(const RowView& rows, std::size_t i) {
    return {rows.lines[6 * i], rows.lines[6 * i + 1], rows.lines[6 * i + 2]};
  }

  static bool is_long(HitColumn column) { return info_of(column).type == "<u8"; }

  static const char* ply_type(HitColumn column) {
    const std::string_view type = info_of(column).type;
    if (type == "<f4") return "float";
    if (type == "<u4") return "uint";
    return type == "|u1" ? "uchar" : "double";  // there is no integer of 64 bits
  }

  static void add_value(const RowView& rows, std::size_t i, HitColumn column, std::string& bytes) {
    std::array<char, 8> value{};
    put_bytes(rows, i, column, value.data());
    if (is_long(column)) {
      std::uint64_t number = 0;
      std::memcpy(&number, value.data(), sizeof(number));
      const auto real = static_cast<double>(number);
      std::memcpy(value.data(), &real, sizeof(real));
    }
    bytes.append(value.data(), info_of(column).bytes);
  }

  HitFormatOptions options_;
};

}  // namespace

std::array<double, 3> hit_point(const RowView& rows, std::size_t i) {
  std::array<double, 3> point{};
  for (std::size_t k = 0; k < 3; ++k)
    point[k] = rows.lines[6 * i + k] + rows.t[i] * rows.lines[6 * i + 3 + k];
  return point;
}

std::unique_ptr<HitFormat> make_hit_format(Format format, HitFormatOptions options) {
  switch (format) {
    case Format::kNdjson:
      return std::make_unique<JsonHits>(std::move(options));
    case Format::kNpy:
      return std::make_unique<NpyHits>(std::move(options));
    case Format::kNpz:
      return std::make_unique<NpzHits>(std::move(options));
    case Format::kPly:
      return std::make_unique<PlyHits>(std::move(options));
    case Format::kCsv:
      break;
  }
  return std::make_unique<CsvHits>(std::move(options));
}

}  // namespace sightline::client::cli::files
