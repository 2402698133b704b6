// Hashes of answers: equal answers have equal hashes on every machine.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string>

#include "accel/geometry/ray.h"
#include "scenegraph/trace.h"

namespace sightline::bench {

/// 64-bit FNV-1a.
class Fingerprint {
 public:
  /// The low `bytes` bytes of a value.
  void add(std::uint64_t value, int bytes = 8) {
    for (int i = 0; i < bytes; ++i) {
      hash_ = (hash_ ^ (value >> (8 * i) & 0xff)) * 0x100000001b3u;
    }
  }
  /// All bits count: NaN equals itself, and 0 differs from -0.
  void add_bits(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add_bits(float value) { add(std::bit_cast<std::uint32_t>(value), 4); }
  /// All columns: state, t, node, primitive, weights, normal; without the work.
  void add_columns(const accel::geometry::Hit& hit);

  std::uint64_t value() const { return hash_; }
  /// As 16 hexadecimal digits.
  std::string text() const;

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

/// The hash over (hit, node, primitive) of all rays in order; for kAny over hit only.
std::string hit_hash(std::span<const accel::geometry::Hit> hits, scenegraph::QueryKind kind);

}  // namespace sightline::bench
