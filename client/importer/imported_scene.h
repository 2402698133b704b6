// A scene file as plain arrays (meshes, and the hierarchy of nodes that have them), and how it is
// imported.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/result.h"
#include "client/types.h"

namespace sightline::client::importer {

/// The value for "no parent" and "no mesh".
inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

struct ImportedMesh {
  std::string name;
  std::vector<Vertex> vertices;
  std::vector<Face> faces;      ///< by primitive id; all kNoVertex: no triangle
  std::uint64_t triangles = 0;  ///< faces that hold a triangle
  std::uint64_t lines_and_points = 0;
};

struct ImportedNode {
  std::string name;              ///< UTF-8, at most kMaxNodeName bytes; not necessarily unique
  std::uint32_t parent = kNone;  ///< an earlier node
  /// Rows of [linear | translation], parent from local.
  std::array<double, 12> parent_from_local{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  std::uint32_t mesh = kNone;
};

inline constexpr std::size_t kMaxNodeName = 1024;  ///< bytes

/// What is missing or differs from the file, though the file could be read.
struct Warning {
  std::string kind;         ///< one or a few words in lower_snake, which stay the same
  std::uint64_t count = 1;  ///< how often
  std::string first{};      ///< where first: a node, a mesh and a face; may be empty
  std::string message{};    ///< for people, after the path of the file; without it for a note
  bool is_note = false;     ///< A fact that may be as it should be, like the border of a terrain.
};

struct ImportedScene {
  std::vector<ImportedMesh> meshes;
  std::vector<ImportedNode> nodes;    ///< parents before children
  UpAxis up_axis = UpAxis::kUnknown;  ///< the arrays' as they are here
  double meters_per_unit = 0;         ///< 0: the file does not say
  std::vector<Warning> warnings{};
};

struct ImportOptions {
  /// The up axis of the result. The scene is turned if the file states another axis; otherwise the
  /// axis is only recorded.
  std::optional<UpAxis> up_axis;
  /// The unit of the result, > 0. The scene is scaled if the file states another unit; otherwise
  /// the unit is only recorded.
  std::optional<double> meters_per_unit;
  /// The offsets of the meshes (Rig::offsets), to be those of another file that has as many. They
  /// are chosen otherwise.
  std::vector<std::array<double, 3>> offsets{};
};

/// The error of a file that cannot be imported.
inline Error import_error(std::string message) {
  return {Code::kInvalidArgument, std::move(message), {}};
}

/// Called with the share of the file that is read, 0 to 1, on the importing thread.
using ImportProgress = std::function<void(double fraction)>;

}  // namespace sightline::client::importer
