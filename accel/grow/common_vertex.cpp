// Telling by one face whether most share a vertex with it.
#include "accel/grow/common_vertex.h"

#include <algorithm>
#include <array>

namespace sightline::accel::grow {
namespace {

/// Shorter lists come to little whatever they do.
constexpr std::size_t kLong = 32;

/// So many of a list are looked at, or a few more.
constexpr std::size_t kLooks = 32;

/// References a face that cuts may make of those that meet: for each a ray gains little.
constexpr double kMeeting = 3.5;

}  // namespace

bool one_side_keeps_all(std::size_t before, std::size_t left, std::size_t right) {
  const auto [fewer, more] = std::minmax(left, right);
  return before > kLong && before - std::min(before, more) <= before / 32 && fewer >= before / 8;
}

bool meet_in_a_vertex(const geometry::MeshView& mesh, std::span<const kdtree::Reference> faces) {
  if (faces.empty()) return false;
  const geometry::Face& one = mesh.faces[faces[faces.size() / 2].id];
  std::array<std::size_t, 3> meeting{};
  const std::size_t stride = std::max<std::size_t>(faces.size() / kLooks, 1);
  std::size_t looks = 0;
  for (std::size_t k = 0; k < faces.size(); k += stride) {
    const kdtree::Reference& ref = faces[k];
    ++looks;
    if (ref.openable()) return false;
    const geometry::Face& other = mesh.faces[ref.id];
    for (std::size_t i = 0; i < 3; ++i) {
      const geometry::Vec3f& v = mesh.vertices[one[i]];
      meeting[i] += mesh.vertices[other[0]] == v || mesh.vertices[other[1]] == v ||
                            mesh.vertices[other[2]] == v
                        ? 1u
                        : 0u;
    }
  }
  return 4 * *std::max_element(meeting.begin(), meeting.end()) >= 3 * looks;
}

kdtree::CellPath capped_budget(const kdtree::CellPath& path, std::size_t references) {
  kdtree::CellPath less = path;
  less.references_left =
      std::min(path.references_left, (kMeeting - 1) * static_cast<double>(references));
  return less;
}

}  // namespace sightline::accel::grow
