// Hashes of answers.
#include "tests/bench/verbs/hit_hash.h"

#include <fmt/core.h>

namespace sightline::bench {

void Fingerprint::add_columns(const accel::geometry::Hit& hit) {
  add(static_cast<std::uint64_t>(hit.state), 1);
  add_bits(hit.t);
  add(hit.node);
  add(hit.primitive, 4);
  add_bits(hit.u);
  add_bits(hit.v);
  for (std::size_t a = 0; a < 3; ++a) add_bits(hit.normal[a]);
}

std::string Fingerprint::text() const { return fmt::format("{:016x}", hash_); }

std::string hit_hash(std::span<const accel::geometry::Hit> hits, scenegraph::QueryKind kind) {
  Fingerprint print;
  for (const accel::geometry::Hit& hit : hits) {
    print.add(static_cast<std::uint64_t>(hit.state), 1);
    if (kind == scenegraph::QueryKind::kAny) continue;
    print.add(hit.node);
    print.add(hit.primitive, 4);
  }
  return print.text();
}

}  // namespace sightline::bench
