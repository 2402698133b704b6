// Animations of a scene file as plain data: key frames and their values in between, skins, and
// shapes to blend.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "client/importer/imported_scene.h"
#include "client/types.h"

namespace sightline::client::importer {

using Point = std::array<double, 3>;
using Quaternion = std::array<double, 4>;  ///< w x y z, of unit length

/// The value of a track before its first key or after its last key.
enum class Beyond : std::uint8_t {
  kHold,         ///< the nearest key
  kExtrapolate,  ///< continues along the two nearest keys
  kRepeat,       ///< repeats from the other end
};

/// The value of a track between two keys.
enum class Interpolation : std::uint8_t {
  kLinear,  ///< rotations along the shorter arc, at constant speed
  kStep,    ///< the value of the earlier key
  kCubic,   ///< a cubic spline with the tangents of the keys
};

template <class Value>
struct Key {
  double seconds = 0;
  Value value{};
};

/// How fast a cubic track arrives at a key and leaves it, in units of the value per second.
template <class Value>
struct Tangents {
  Value in{}, out{};
};

/// Keys in order of time, at least one.
template <class Value>
struct Track {
  std::vector<Key<Value>> keys;  ///< rotations of a cubic track may have any length
  Beyond before = Beyond::kHold;
  Beyond after = Beyond::kHold;  ///< a cubic track holds
  Interpolation interpolation = Interpolation::kLinear;
  std::vector<Tangents<Value>> tangents{};  ///< for each key of a cubic track; else empty
};

/// The value at a time. Rotations have unit length. A weight that only one of two keys has counts
/// as 0 in the other. Value is Point, Quaternion or std::vector<double>.
template <class Value>
Value sample(const Track<Value>& track, double seconds);

/// A node's transform: scaling, then rotation, then translation.
struct NodeChannel {
  std::uint32_t node = kNone;
  Track<Point> positions;
  Track<Quaternion> rotations;
  Track<Point> scalings;
};

/// Vertices of a mesh that follow nodes. Vertex v follows influences[first[v]] up to
/// influences[first[v + 1]], whose weights add up to 1. A vertex without influences stays.
struct Skin {
  struct Bone {
    std::uint32_t node = kNone;
    Transform bone_from_mesh = kIdentity;
  };
  struct Influence {
    std::uint32_t bone = 0;
    double weight = 0;
  };
  std::vector<Bone> bones;  ///< empty: the mesh has no skin
  std::vector<std::uint32_t> first;
  std::vector<Influence> influences;
};

/// Other shapes of a mesh (morph targets), as the offset of each vertex.
using Shapes = std::vector<std::vector<std::array<float, 3>>>;

/// A node whose mesh changes its vertices. Shapes are blended first, then the skin is applied.
struct Deformation {
  std::uint32_t node = kNone;
  std::uint32_t mesh = kNone;
  Track<std::vector<double>> weights;  ///< weights of the mesh's shapes; no keys: not animated
};

struct Animation {
  std::string name;
  double seconds = 0;  ///< duration; the animation starts at 0
  std::vector<NodeChannel> channels;
  std::vector<Deformation> deformations;
};

/// What poses are computed from: the scene as it is in the file, and the transform from there to
/// the imported scene.
struct Rig {
  std::vector<Transform> parent_from_local;  ///< each node's at rest, in the file
  Transform scene_from_file = kIdentity;     ///< applied before the roots
  /// What was subtracted from each mesh's vertices, and added to the transforms of the nodes that
  /// have it
  std::vector<Point> offsets;
  /// Each mesh's vertices without a pose, in the file. Empty for a mesh without skin and shapes.
  std::vector<std::vector<Point>> vertices;
  std::vector<Skin> skins;                   ///< by mesh
  std::vector<Shapes> shapes;                ///< by mesh
  std::vector<std::vector<double>> weights;  ///< by mesh: those of its shapes at rest, or fewer
};

struct AnimatedScene {
  ImportedScene scene;
  Rig rig;
  std::vector<Animation> animations;  ///< all animations of the file that move something
};

}  // namespace sightline::client::importer
