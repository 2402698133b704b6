// One function for each type and byte order.
#include "client/cli/files/scalar.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

namespace sightline::client::cli::files {
namespace {

struct Half {
  std::uint16_t bits;

  explicit operator double() const {
    const auto exponent = static_cast<int>(bits >> 10U & 0x1fU);
    const auto fraction = static_cast<int>(bits & 0x3ffU);
    double magnitude = std::ldexp(fraction, -24);
    if (exponent == 31) {
      magnitude = fraction == 0 ? std::numeric_limits<double>::infinity()
                                : std::numeric_limits<double>::quiet_NaN();
    } else if (exponent > 0) {
      magnitude = std::ldexp(1024 + fraction, exponent - 25);
    }
    return (bits & 0x8000U) != 0 ? -magnitude : magnitude;
  }
};

template <class T, bool swapped>
double load(const std::byte* at) {
  std::array<std::byte, sizeof(T)> bytes;
  std::memcpy(bytes.data(), at, sizeof(T));
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  T value;
  std::memcpy(&value, bytes.data(), sizeof(T));
  return static_cast<double>(value);
}

template <class T>
ScalarType scalar_type(bool swapped) {
  return {sizeof(T), std::is_same_v<T, float>, swapped ? load<T, true> : load<T, false>};
}

using MakeType = ScalarType (*)(bool swapped);
using NamedType = std::pair<std::string_view, MakeType>;

constexpr std::array<NamedType, 12> kNpyTypes{{{"f2", scalar_type<Half>},
                                               {"f4", scalar_type<float>},
                                               {"f8", scalar_type<double>},
                                               {"i1", scalar_type<std::int8_t>},
                                               {"i2", scalar_type<std::int16_t>},
                                               {"i4", scalar_type<std::int32_t>},
                                               {"i8", scalar_type<std::int64_t>},
                                               {"u1", scalar_type<std::uint8_t>},
                                               {"u2", scalar_type<std::uint16_t>},
                                               {"u4", scalar_type<std::uint32_t>},
                                               {"u8", scalar_type<std::uint64_t>},
                                               {"b1", scalar_type<std::uint8_t>}}};

constexpr std::array<NamedType, 16> kPlyTypes{{{"char", scalar_type<std::int8_t>},
                                               {"uchar", scalar_type<std::uint8_t>},
                                               {"short", scalar_type<std::int16_t>},
                                               {"ushort", scalar_type<std::uint16_t>},
                                               {"int", scalar_type<std::int32_t>},
                                               {"uint", scalar_type<std::uint32_t>},
                                               {"float", scalar_type<float>},
                                               {"double", scalar_type<double>},
                                               {"int8", scalar_type<std::int8_t>},
                                               {"uint8", scalar_type<std::uint8_t>},
                                               {"int16", scalar_type<std::int16_t>},
                                               {"uint16", scalar_type<std::uint16_t>},
                                               {"int32", scalar_type<std::int32_t>},
                                               {"uint32", scalar_type<std::uint32_t>},
                                               {"float32", scalar_type<float>},
                                               {"float64", scalar_type<double>}}};

template <std::size_t n>
std::optional<ScalarType> find_type(const std::array<NamedType, n>& types, std::string_view name,
                                    bool swapped) {
  for (const auto& [known, make] : types) {
    if (known == name) return make(swapped);
  }
  return {};
}

}  // namespace

std::optional<ScalarType> scalar_of_npy(std::string_view dtype) {
  if (dtype.size() != 3) return {};
  return find_type(kNpyTypes, dtype.substr(1), dtype.front() == '>');
}

std::optional<ScalarType> scalar_of_ply(std::string_view name, bool big_endian) {
  return find_type(kPlyTypes, name, big_endian);
}

}  // namespace sightline::client::cli::files
