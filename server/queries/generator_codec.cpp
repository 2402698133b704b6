// Decodes a generator of rays.
#include "server/queries/generator_codec.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/exec/rpc_status.h"

namespace sightline::server::queries {
namespace {

using Numbers = google::protobuf::RepeatedField<double>;
using proto::rays::Vector;

/// Sets `out` to the numbers of a field.
template <std::size_t size>
Status decode_numbers(std::string_view name, const Numbers& numbers,
                      std::array<double, size>& out) {
  if (numbers.size() != static_cast<int>(size)) {
    return exec::invalid_argument(
        fmt::format("{} has {} numbers, expected {}", name, numbers.size(), size), "NUMBER_COUNT");
  }
  std::copy(numbers.begin(), numbers.end(), out.begin());
  return {};
}

Status decode_samples(const Numbers& numbers, std::vector<std::array<double, 2>>& samples) {
  constexpr int kMostNumbers = 2 * static_cast<int>(proto::rays::kMaxSamples);
  if (numbers.size() % 2 != 0 || numbers.size() > kMostNumbers) {
    return exec::invalid_argument(
        fmt::format("samples has {} numbers, expected an even number up to {}", numbers.size(),
                    kMostNumbers),
        "NUMBER_COUNT");
  }
  for (int i = 0; i < numbers.size(); i += 2) samples.push_back({numbers[i], numbers[i + 1]});
  return {};
}

Status decode_kind(const v1::Pinhole& message, proto::rays::Pinhole& pinhole) {
  if (Status s = decode_numbers("eye", message.eye(), pinhole.eye); !s) return s;
  if (Status s = decode_numbers("corner", message.corner(), pinhole.corner); !s) return s;
  if (Status s = decode_numbers("across", message.across(), pinhole.across); !s) return s;
  if (Status s = decode_numbers("down", message.down(), pinhole.down); !s) return s;
  pinhole.width = message.width();
  pinhole.height = message.height();
  pinhole.tiled = message.tiled();
  return decode_samples(message.samples(), pinhole.samples);
}

Status decode_kind(const v1::SphericalScan& message, proto::rays::SphericalScan& scan) {
  if (Status s = decode_numbers("origin", message.origin(), scan.origin); !s) return s;
  if (Status s = decode_numbers("forward", message.forward(), scan.forward); !s) return s;
  if (Status s = decode_numbers("left", message.left(), scan.left); !s) return s;
  if (Status s = decode_numbers("up", message.up(), scan.up); !s) return s;
  if (Status s = decode_numbers("azimuth", message.azimuth(), scan.azimuth); !s) return s;
  if (Status s = decode_numbers("elevation", message.elevation(), scan.elevation); !s) return s;
  scan.columns = message.columns();
  scan.rows = message.rows();
  return {};
}

/// Sets `rows` to a column of arrays of T.
template <class T, class Row>
Status decode_rows(std::string_view name, const std::string& column, std::vector<Row>& rows) {
  using Stored = std::array<T, std::tuple_size_v<Row>>;
  if (column.size() % sizeof(Stored) != 0) {
    return exec::invalid_argument(fmt::format("column {} has {} bytes, expected a multiple of {}",
                                              name, column.size(), sizeof(Stored)),
                                  "COLUMN_LENGTH");
  }
  rows.resize(column.size() / sizeof(Stored));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Stored stored;
    std::memcpy(&stored, column.data() + i * sizeof(Stored), sizeof(Stored));
    std::copy(stored.begin(), stored.end(), rows[i].begin());
  }
  return {};
}

Status decode_points(std::string_view name, const std::string& column, bool float64,
                     std::vector<Vector>& points) {
  return float64 ? decode_rows<double>(name, column, points)
                 : decode_rows<float>(name, column, points);
}

Status decode_kind(const v1::VisibilityPairs& message, proto::rays::VisibilityPairs& pairs) {
  const bool float64 = message.float64();
  if (Status s = decode_points("from", message.from(), float64, pairs.from); !s) return s;
  if (Status s = decode_points("to", message.to(), float64, pairs.to); !s) return s;
  return decode_rows<std::uint32_t>("pairs", message.pairs(), pairs.pairs);
}

template <class Message, class Kind>
Status decode_into(proto::rays::RayGenerator& generator, const Message& message, Kind kind) {
  Status decoded = decode_kind(message, kind);
  if (decoded) generator.rays = std::move(kind);
  return decoded;
}

Status decode_rays_of(const v1::RayGenerator& message, proto::rays::RayGenerator& generator) {
  switch (message.kind_case()) {
    case v1::RayGenerator::kPinhole:
      return decode_into(generator, message.pinhole(), proto::rays::Pinhole{});
    case v1::RayGenerator::kScan:
      return decode_into(generator, message.scan(), proto::rays::SphericalScan{});
    case v1::RayGenerator::kPairs:
      return decode_into(generator, message.pairs(), proto::rays::VisibilityPairs{});
    case v1::RayGenerator::KIND_NOT_SET:
      break;
  }
  return exec::invalid_argument("the generator has no kind that this server knows",
                                "UNKNOWN_GENERATOR");
}

}  // namespace

Result<proto::rays::RayGenerator> decode_generator(const v1::RayGenerator& message) {
  proto::rays::RayGenerator generator{.first = message.first(), .count = message.count()};
  if (message.has_tmin()) generator.tmin = message.tmin();
  if (message.has_tmax()) generator.tmax = message.tmax();
  if (message.has_mask()) generator.mask = message.mask();
  if (const Status decoded = decode_rays_of(message, generator); !decoded) return decoded.error();
  if (const auto problem = proto::rays::check(generator))
    return exec::invalid_argument(problem->message, problem->reason);
  return generator;
}

}  // namespace sightline::server::queries
