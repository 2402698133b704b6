// Telling by one face whether most share a vertex with it.
#include "accel/build/common_vertex.h"

#include <algorithm>
#include <array>

namespace sightline::accel {
namespace {

/// Shorter lists come to little whatever they do.
constexpr std::size_t kLong = 32;

/// References a face that cuts may make of those that meet: for each a ray gains little.
constexpr double kMeeting = 3.5;

}  // namespace

bool keeps_all(std::size_t before, std::size_t left, std::size_t right) {
  const auto [fewer, more] = std::minmax(left, right);
  return before > kLong && before - std::min(before, more) <= before / 32 && fewer >= before / 8;
}

bool meet_in_a_vertex(const MeshView& mesh, std::span<const BoxRef> faces) {
  if (faces.empty()) return false;
  const Face& one = mesh.faces[faces[faces.size() / 2].id];
  std::array<std::size_t, 3> meeting{};
  for (const BoxRef& ref : faces) {
    if (ref.openable()) return false;
    const Face& other = mesh.faces[ref.id];
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3f& v = mesh.vertices[one[i]];
      meeting[i] += mesh.vertices[other[0]] == v || mesh.vertices[other[1]] == v ||
                            mesh.vertices[other[2]] == v
                        ? 1u
                        : 0u;
    }
  }
  return 4 * *std::max_element(meeting.begin(), meeting.end()) >= 3 * faces.size();
}

CellPath with_less(const CellPath& path, std::size_t references) {
  CellPath less = path;
  less.spare = std::min(path.spare, (kMeeting - 1) * static_cast<double>(references));
  return less;
}

}  // namespace sightline::accel
