// A fingerprint of answers: equal answers, equal number, on every machine.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "accel/geometry/ray.h"
#include "scenegraph/trace.h"

namespace sightline::bench {

/// 64-bit FNV-1a over (hit, node, primitive) of every ray in order, as 16 hexadecimal digits; for
/// kAny over hit alone.
std::string hit_hash(std::span<const accel::Hit> hits, scenegraph::QueryKind kind);

}  // namespace sightline::bench
