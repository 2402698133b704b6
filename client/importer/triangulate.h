// Cuts polygons into triangles. Internal to the importer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "client/types.h"

namespace sightline::client::importer {

/// Cuts polygons of one mesh, whose vertices it keeps a reference to. Not from two threads at once.
class Triangulator {
 public:
  explicit Triangulator(const std::vector<Vertex>& vertices);
  Triangulator(const Triangulator&) = delete;
  Triangulator& operator=(const Triangulator&) = delete;
  ~Triangulator();

  /// Appends the n - 2 triangles of a polygon with these n >= 3 corners. Triangles turn as the
  /// polygon does, and together they cover it exactly once: seen along an axis, if it is not flat.
  /// A polygon may have corners on a straight line, equal corners, and boundaries that touch, as
  /// where an edge leads to a hole and back; triangles without area stand for corners that cover
  /// nothing. All triangles of a polygon with a vertex that is not finite have such a vertex.
  /// Returns whether the polygon does not intersect itself, by more than the rounding of floats. If
  /// it does, the triangles have its corners and its outline, and overlap. So they may if it
  /// touches itself at one place thousands of times, where finding out would take quadratic time:
  /// this returns false, too. Crossings of a polygon of tens of thousands of edges that are near
  /// each other all along may stay unnoticed. Decisions are exact. A convex polygon takes O(n)
  /// time, others O(n log n), as a rule, and at most a number of steps for each corner.
  bool cut(std::span<const std::uint32_t> corners, std::vector<Face>& faces);

 private:
  class Work;

  const std::vector<Vertex>& vertices_;
  std::unique_ptr<Work> work_;  // storage that is used again
};

}  // namespace sightline::client::importer
