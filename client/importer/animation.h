// Animations of a scene file as plain data: key frames of nodes, skins, and shapes to blend.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "client/importer/imported_scene.h"
#include "client/types.h"

namespace sightline::client::importer {

using Point = std::array<double, 3>;
using Quaternion = std::array<double, 4>;  ///< w x y z, of unit length.

/// What a track is before its first key or after its last.
enum class Beyond : std::uint8_t {
  kHold,         ///< The nearest key.
  kExtrapolate,  ///< On along the two nearest keys.
  kRepeat,       ///< From the other end on.
};

template <class Value>
struct Key {
  double seconds = 0;
  Value value{};
};

/// Keys in order of time, at least one. Between two of them values are mixed, rotations on the
/// shorter arc.
template <class Value>
struct Track {
  std::vector<Key<Value>> keys;
  Beyond before = Beyond::kHold;
  Beyond after = Beyond::kHold;
};

/// A node's transform: scaled, then rotated, then moved.
struct NodeChannel {
  std::uint32_t node = kNone;
  Track<Point> positions;
  Track<Quaternion> rotations;
  Track<Point> scalings;
};

/// Vertices of a mesh that follow nodes. Vertex v follows those of influences[first[v]] up to
/// influences[first[v + 1]], whose weights add up to 1; none: it stays.
struct Skin {
  struct Bone {
    std::uint32_t node = kNone;
    Transform bone_from_mesh = kIdentity;
  };
  struct Influence {
    std::uint32_t bone = 0;
    double weight = 0;
  };
  std::vector<Bone> bones;  ///< Empty: the mesh has no skin.
  std::vector<std::uint32_t> first;
  std::vector<Influence> influences;
};

/// Other shapes of a mesh: how far each vertex is from where the mesh has it.
using Shapes = std::vector<std::vector<std::array<float, 3>>>;

/// A node whose mesh changes its vertices. Shapes are blended first, then the skin is put on.
struct Deformation {
  std::uint32_t node = kNone;
  std::uint32_t mesh = kNone;
  Track<std::vector<double>> weights;  ///< Of the mesh's shapes; no keys: they are not animated.
};

struct Animation {
  std::string name;
  double seconds = 0;  ///< From its begin, 0, to its end.
  std::vector<NodeChannel> channels;
  std::vector<Deformation> deformations;
};

/// What poses are made with: the scene as it is in the file, and the way from there.
struct Rig {
  std::vector<Transform> parent_from_local;  ///< Of each node at rest, in the file.
  Transform scene_from_file = kIdentity;     ///< Was put before the roots.
  Point offset{};  ///< Was taken from all vertices, and put into the nodes that carry them.
  std::vector<Skin> skins;     ///< By mesh.
  std::vector<Shapes> shapes;  ///< By mesh.
};

struct AnimatedScene {
  ImportedScene scene;
  Rig rig;
  std::vector<Animation> animations;  ///< Of those in the file, all that move something.
};

}  // namespace sightline::client::importer
