// Finds the columns in arrays.
#include "client/cli/files/ray_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "client/cli/files/npy.h"
#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

using Shape = std::vector<std::uint64_t>;

// The product; nothing beyond 2^64.
std::optional<std::uint64_t> product(std::span<const std::uint64_t> factors) {
  std::uint64_t all = 1;
  for (const std::uint64_t factor : factors) {
    if (__builtin_mul_overflow(all, factor, &all)) return {};
  }
  return all;
}

std::string text_of(const Shape& shape) {
  return fmt::format("({}{})", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
}

// The elements of an array in Fortran order, in C order.
std::shared_ptr<std::vector<std::byte>> in_c_order(const std::byte* from, const Shape& shape,
                                                   std::size_t item) {
  std::vector<std::uint64_t> stride(shape.size());
  std::uint64_t count = 1;
  for (std::size_t k = 0; k < shape.size(); ++k) {
    stride[k] = count * item;
    count *= shape[k];
  }
  auto out = std::make_shared<std::vector<std::byte>>(count * item);
  Shape index(shape.size());
  std::uint64_t offset = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    std::memcpy(out->data() + i * item, from + offset, item);
    for (std::size_t k = shape.size(); k-- > 0;) {
      offset += stride[k];
      if (++index[k] < shape[k]) break;
      offset -= stride[k] * shape[k];
      index[k] = 0;
    }
  }
  return out;
}

Shape leading(const Shape& shape) { return {shape.begin(), shape.end() - 1}; }

TableColumn column_of(const NpyArray& array, std::uint64_t k, std::uint64_t width) {
  return {array.data + k * array.type.bytes, width * array.type.bytes, array.type};
}

bool has_rows_of(const NpyArray& array, std::uint64_t width) {
  return !array.shape.empty() && array.shape.back() == width;
}

}  // namespace

std::uint64_t RayTable::rows() const { return product(shape).value_or(0); }

bool RayTable::is_float32() const {
  return std::all_of(columns.begin(), columns.end(), [](const TableColumn& column) {
    return column.data == nullptr || column.type.is_float32;
  });
}

Result<NpyArray> parse_npy_array(std::span<const std::byte> file, RowKind kind) {
  const auto header = parse_npy_header(file);
  if (!header) return header.error();
  const auto type = scalar_of_npy(header->dtype);
  if (!type) {
    return local_error(
        fmt::format("dtype is {}, {} have real numbers: f2 f4 f8, i1 to i8, u1 to u8",
                    header->dtype, layout_of(kind).rows));
  }
  const auto data = file.subspan(header->data_offset);
  const auto count = product(header->shape);
  if (!count || *count > data.size() / type->bytes) {
    return local_error(fmt::format("cut off: {} bytes of numbers, the shape {} needs more",
                                   data.size(), text_of(header->shape)));
  }
  NpyArray array{header->shape, *type, data.data()};
  if (!header->fortran_order || array.shape.size() < 2) return array;
  const auto moved = in_c_order(data.data(), array.shape, type->bytes);
  array.data = moved->data();
  array.owner = moved;
  return array;
}

Result<RayTable> table_of(const NpyArray& rows, RowKind kind) {
  const RowLayout& layout = layout_of(kind);
  if (!has_rows_of(rows, layout.required) && !has_rows_of(rows, layout.names.size())) {
    return local_error(fmt::format("shape is {}, {} have (..., {}) or (..., {})",
                                   text_of(rows.shape), layout.rows, layout.required,
                                   layout.names.size()));
  }
  const std::uint64_t width = rows.shape.back();
  RayTable table{.shape = leading(rows.shape), .owners = {rows.owner}};
  for (std::uint64_t k = 0; k < width; ++k)
    table.columns[layout.columns[k]] = column_of(rows, k, width);
  return table;
}

Result<RayTable> table_of(const NpyArray& origins, const NpyArray& directions, const NpyArray* tmin,
                          const NpyArray* tmax) {
  if (!has_rows_of(origins, 3) || directions.shape != origins.shape) {
    return local_error(fmt::format("origins are {} and directions {}, both have (..., 3)",
                                   text_of(origins.shape), text_of(directions.shape)));
  }
  if ((tmin == nullptr) != (tmax == nullptr)) {
    return local_error("tmin and tmax are both there, or neither is");
  }
  RayTable table{.shape = leading(origins.shape), .owners = {origins.owner, directions.owner}};
  for (std::size_t k = 0; k < 3; ++k) {
    table.columns[k] = column_of(origins, k, 3);
    table.columns[3 + k] = column_of(directions, k, 3);
  }
  if (tmin == nullptr) return table;
  if (tmin->shape != table.shape || tmax->shape != table.shape) {
    return local_error(fmt::format("tmin is {} and tmax {}, the rays are {}", text_of(tmin->shape),
                                   text_of(tmax->shape), text_of(table.shape)));
  }
  table.columns[6] = column_of(*tmin, 0, 1);
  table.columns[7] = column_of(*tmax, 0, 1);
  table.owners.insert(table.owners.end(), {tmin->owner, tmax->owner});
  return table;
}

Result<RayTable> table_of_points(const NpyArray& positions, const NpyArray* max) {
  if (!has_rows_of(positions, 3))
    return local_error(fmt::format("positions are {}, not (..., 3)", text_of(positions.shape)));
  RayTable table{.shape = leading(positions.shape), .owners = {positions.owner}};
  for (std::size_t k = 0; k < 3; ++k) table.columns[k] = column_of(positions, k, 3);
  if (max == nullptr) return table;
  if (max->shape != table.shape) {
    return local_error(
        fmt::format("max is {}, the points are {}", text_of(max->shape), text_of(table.shape)));
  }
  table.columns[7] = column_of(*max, 0, 1);
  table.owners.push_back(max->owner);
  return table;
}

template <class Scalar>
RaySource<Scalar> source_of(std::shared_ptr<const RayTable> table) {
  return [table = std::move(table), next = std::uint64_t{0}](
             const RayColumns<Scalar>& buffer) mutable -> Result<std::size_t> {
    const std::size_t n = std::min<std::uint64_t>(buffer.size(), table->rows() - next);
    for (std::size_t i = 0; i < n; ++i, ++next) {
      const auto value = [&](std::size_t k) {
        return static_cast<Scalar>(table->columns[k].at(next));
      };
      for (std::size_t k = 0; k < 3; ++k) {
        buffer.origins[3 * i + k] = value(k);
        if (!buffer.directions.empty()) buffer.directions[3 * i + k] = value(3 + k);
      }
      if (!buffer.tmin.empty()) buffer.tmin[i] = value(6);
      if (!buffer.tmax.empty()) buffer.tmax[i] = value(7);
    }
    return n;
  };
}

template RaySource<float> source_of(std::shared_ptr<const RayTable>);
template RaySource<double> source_of(std::shared_ptr<const RayTable>);

}  // namespace sightline::client::cli::files
