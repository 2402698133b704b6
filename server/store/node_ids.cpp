// Lists of node ids as bytes.
#include "server/store/node_ids.h"

#include <cstdint>

namespace sightline::server::store {
namespace {

constexpr unsigned kBits = 7;  // bits of a number in each byte
constexpr std::uint64_t kMore = 0x80;
constexpr unsigned kLastShift = 63;

}  // namespace

std::string encode_ids(const std::vector<NodeId>& ids) {
  std::string bytes;
  bytes.reserve(ids.size());
  NodeId last = 0;
  for (const NodeId id : ids) {
    // The step is modulo 2^64, with the sign in the lowest bit, so that steps down are short too.
    const std::uint64_t step = id - last;
    std::uint64_t rest = (step << 1) ^ (step >> kLastShift != 0 ? ~std::uint64_t{0} : 0);
    for (; rest >= kMore; rest >>= kBits) bytes.push_back(static_cast<char>(rest | kMore));
    bytes.push_back(static_cast<char>(rest));
    last = id;
  }
  return bytes;
}

std::optional<std::vector<NodeId>> decode_ids(std::span<const std::byte> bytes) {
  std::vector<NodeId> ids;
  NodeId last = 0;
  std::uint64_t number = 0;
  unsigned shift = 0;
  for (const std::byte byte : bytes) {
    if (shift > kLastShift) return std::nullopt;
    const auto value = std::to_integer<std::uint64_t>(byte);
    number |= (value & (kMore - 1)) << shift;
    shift += kBits;
    if ((value & kMore) != 0) continue;
    last += (number >> 1) ^ (0 - (number & 1));
    ids.push_back(last);
    number = 0;
    shift = 0;
  }
  if (shift != 0) return std::nullopt;
  return ids;
}

}  // namespace sightline::server::store
