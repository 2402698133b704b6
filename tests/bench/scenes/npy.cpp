// Writes rays as NumPy's .npy files.
#include "tests/bench/scenes/npy.h"

#include <fmt/core.h>

#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <string>

namespace sightline::bench {

static_assert(std::endian::native == std::endian::little, "rays are written as they lie in memory");

Status write_rays(const std::filesystem::path& file, std::span<const accel::geometry::Ray> rays) {
  // Version 1.0: magic, header length, a Python literal, padded so that the data is 64-byte
  // aligned.
  std::string header =
      fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, 8), }}", rays.size());
  constexpr std::size_t kPreamble = 10;
  header.append(63 - (kPreamble + header.size()) % 64, ' ');
  header += '\n';
  std::string preamble = std::string("\x93NUMPY\x01", 7) + '\0';
  preamble += static_cast<char>(header.size() & 0xff);
  preamble += static_cast<char>(header.size() >> 8);

  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out << preamble << header;
  for (const accel::geometry::Ray& ray : rays) {
    const std::array<double, 8> row{ray.origin.x,    ray.origin.y,    ray.origin.z, ray.direction.x,
                                    ray.direction.y, ray.direction.z, ray.tmin,     ray.tmax};
    std::array<char, sizeof(row)> bytes;
    std::memcpy(bytes.data(), row.data(), sizeof(row));
    out.write(bytes.data(), bytes.size());
  }
  out.close();
  if (out.fail()) {
    return Error{Code::kUnavailable, fmt::format("cannot write {}", file.string()), "FILE"};
  }
  return {};
}

}  // namespace sightline::bench
