// Fuzzer bytes as a ray and a patch of triangles.
#pragma once

#include <cstdint>
#include <span>

#include "tests/fuzz/hard_case.h"

namespace sightline::tests {

/// Any bytes make a case: a patch, then the bit patterns of its vertices and of the ray, then steps
/// of four bytes that make ties: copy a coordinate or a vertex, move it by one float, aim the ray
/// at a vertex, along an edge, from a face. Missing bytes are zero; non-finite numbers are made
/// finite.
HardCase decode_case(std::span<const std::uint8_t> bytes);

}  // namespace sightline::tests
