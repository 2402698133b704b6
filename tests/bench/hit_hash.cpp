// A fingerprint of answers.
#include "tests/bench/hit_hash.h"

#include <fmt/core.h>

namespace sightline::bench {

std::string hit_hash(std::span<const accel::Hit> hits, scenegraph::QueryKind kind) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto add = [&](std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) {
      hash = (hash ^ (value >> (8 * i) & 0xff)) * 0x100000001b3u;
    }
  };
  for (const accel::Hit& hit : hits) {
    add(static_cast<std::uint64_t>(hit.state), 1);
    if (kind == scenegraph::QueryKind::kAny) continue;
    add(hit.node, 8);
    add(hit.primitive, 4);
  }
  return fmt::format("{:016x}", hash);
}

}  // namespace sightline::bench
