// Converts rows of a file to columns of a message.
#include "client/cli/files/ray_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <span>
#include <utility>

#include "client/cli/files/csv.h"
#include "client/cli/files/input.h"
#include "client/cli/files/npy.h"
#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

// A matrix in the bytes of a file. The bytes may not be aligned, so values are copied out.
template <class Scalar>
class Matrix {
 public:
  Matrix(std::span<const std::byte> data, std::uint64_t rows, std::uint64_t columns, bool by_column)
      : data_(data.data()),
        row_stride_(by_column ? 1 : columns),
        column_stride_(by_column ? rows : 1) {}

  Scalar at(std::uint64_t row, std::uint64_t column) const {
    Scalar x;
    std::memcpy(&x, data_ + (row * row_stride_ + column * column_stride_) * sizeof(Scalar),
                sizeof(Scalar));
    return x;
  }

 private:
  const std::byte* data_;
  std::uint64_t row_stride_;
  std::uint64_t column_stride_;
};

template <class Scalar>
RaySource<Scalar> npy_source(std::shared_ptr<Input> input, Matrix<Scalar> rays,
                             std::uint64_t rows) {
  return [input = std::move(input), rays, rows, next = std::uint64_t{0}](
             const RayColumns<Scalar>& buffer) mutable -> Result<std::size_t> {
    const std::size_t n = std::min<std::uint64_t>(buffer.size(), rows - next);
    for (std::size_t i = 0; i < n; ++i, ++next) {
      for (std::size_t k = 0; k < 3; ++k) {
        buffer.origins[3 * i + k] = rays.at(next, k);
        buffer.directions[3 * i + k] = rays.at(next, 3 + k);
      }
      if (buffer.tmin.empty()) continue;
      buffer.tmin[i] = rays.at(next, 6);
      buffer.tmax[i] = rays.at(next, 7);
    }
    return n;
  };
}

Error npy_error(const Input& input, const std::string& what) {
  return local_error(fmt::format("{}: {}", input.name(), what));
}

template <class Scalar>
Result<RayFile> npy_rays(std::shared_ptr<Input> input, const NpyHeader& header,
                         std::span<const std::byte> data) {
  const std::uint64_t rows = header.shape[0];
  const std::uint64_t columns = header.shape[1];
  if (data.size() / (columns * sizeof(Scalar)) < rows) {
    return npy_error(*input, fmt::format("cut off: {} bytes of rays, {} of them need {}",
                                         data.size(), rows, rows * columns * sizeof(Scalar)));
  }
  const Matrix<Scalar> rays(data, rows, columns, header.fortran_order);
  return RayFile{npy_source<Scalar>(std::move(input), rays, rows),
                 {.interval = columns == 8, .masks = false},
                 rows};
}

Result<RayFile> open_npy(Input opened) {
  const auto input = std::make_shared<Input>(std::move(opened));
  const auto bytes = input->whole();
  if (!bytes) return bytes.error();
  const auto header = parse_npy_header(*bytes);
  if (!header) return npy_error(*input, header.error().message);
  if (header->shape.size() != 2 || (header->shape[1] != 6 && header->shape[1] != 8)) {
    return npy_error(*input, fmt::format("shape is ({}), rays have (n, 6) or (n, 8)",
                                         fmt::join(header->shape, ", ")));
  }
  const auto data = bytes->subspan(header->data_offset);
  if (header->dtype == "<f4") return npy_rays<float>(input, *header, data);
  if (header->dtype == "<f8") return npy_rays<double>(input, *header, data);
  return npy_error(*input, fmt::format("dtype is {}, rays have <f4 or <f8", header->dtype));
}

Result<RayFile> open_csv(Input input) {
  auto opened = CsvRays::open(std::move(input));
  if (!opened) return opened.error();
  const auto rays = std::make_shared<CsvRays>(*std::move(opened));
  RaySource<double> source = [rays](const RayColumns<double>& buffer) -> Result<std::size_t> {
    RayRow row{};
    for (std::size_t i = 0; i < buffer.size(); ++i) {
      const auto more = rays->next(row);
      if (!more) return more.error();
      if (!*more) return i;
      std::copy_n(row.begin(), 3, buffer.origins.begin() + static_cast<std::ptrdiff_t>(3 * i));
      std::copy_n(row.begin() + 3, 3,
                  buffer.directions.begin() + static_cast<std::ptrdiff_t>(3 * i));
      if (buffer.tmin.empty()) continue;
      buffer.tmin[i] = row[6];
      buffer.tmax[i] = row[7];
    }
    return buffer.size();
  };
  return RayFile{
      std::move(source), {.interval = rays->has_interval(), .masks = false}, std::nullopt};
}

}  // namespace

Result<RayFile> open_rays(const std::string& path, std::stop_token stop) {
  auto input = Input::open(path, std::move(stop));
  if (!input) return input.error();
  const auto start = input->peek(kNpyMagic.size());
  if (!start) return start.error();
  const bool is_npy = *start == kNpyMagic || path.ends_with(".npy");
  return is_npy ? open_npy(*std::move(input)) : open_csv(*std::move(input));
}

}  // namespace sightline::client::cli::files
