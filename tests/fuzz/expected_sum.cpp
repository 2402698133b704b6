// How many triangles of a patch a line must hit.
#include "tests/fuzz/expected_sum.h"

namespace sightline::tests {
namespace {

/// If the line is strictly inside all outer edges, seen from the triangles that they belong to, it
/// is in one of the two triangles or on the open edge between them.
ExpectedSum over_edge(const RationalRay& ray, const ExactVertices& v) {
  const DyadicVec &p = v[0], &q = v[1], &r = v[2], &s = v[3];
  const int first = ray.facing(p, q, r), second = ray.facing(q, p, s);
  if (first == 0 || second == 0) return ExpectedSum::kAny;
  if (ray.side(q, r) != first || ray.side(r, p) != first || ray.side(p, s) != second ||
      ray.side(s, q) != second) {
    return ExpectedSum::kAny;
  }
  return first == second ? ExpectedSum::kOne : ExpectedSum::kNoneOrTwo;
}

/// Whether the rim, seen along the ray, goes around the hub exactly once. All triangles face
/// `turn`.
bool goes_around_once(const RationalRay& ray, const ExactVertices& v, std::size_t rim, int turn) {
  // Angles from the first rim vertex; each step is less than half a turn. A turn is complete when
  // the angle goes from the second half [pi, 2 pi) to the first one.
  int turns = 0;
  bool in_second_half = false;
  for (std::size_t i = 1; i <= rim; ++i) {
    const int side = i == rim ? 0 : ray.facing(v[0], v[1], v[1 + i]) * turn;
    // On the line of the first vertex: behind it if the step started in the first half.
    const bool second = side < 0 || (side == 0 && !in_second_half);
    if (in_second_half && !second) ++turns;
    in_second_half = second;
  }
  return turns == 1 && !in_second_half;
}

/// If the line is strictly inside all edges of the rim, it is in the polygon that the fan covers.
ExpectedSum around_vertex(const RationalRay& ray, const ExactVertices& v, std::size_t rim) {
  const int turn = ray.facing(v[0], v[1], v[2]);
  if (turn == 0) return ExpectedSum::kAny;
  for (std::size_t i = 0; i < rim; ++i) {
    const DyadicVec &p = v[1 + i], &q = v[1 + (i + 1) % rim];
    if (ray.facing(v[0], p, q) != turn || ray.side(p, q) != turn) return ExpectedSum::kAny;
  }
  return goes_around_once(ray, v, rim, turn) ? ExpectedSum::kOne : ExpectedSum::kAny;
}

}  // namespace

ExpectedSum expected_sum(const RationalRay& ray, const HardCase& hard, const ExactVertices& v) {
  switch (hard.patch) {
    case Patch::kTriangle:
      return ExpectedSum::kAny;
    case Patch::kPair:
      return over_edge(ray, v);
    case Patch::kFan:
      return around_vertex(ray, v, hard.face_count);
    case Patch::kTetrahedron:
      return ExpectedSum::kNoneOrTwo;
  }
  return ExpectedSum::kAny;
}

}  // namespace sightline::tests
