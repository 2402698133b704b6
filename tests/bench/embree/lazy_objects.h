// Objects that Embree builds when the first ray comes upon them.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "tests/bench/embree/device.h"
#include "tests/bench/embree/layout.h"

namespace sightline::bench {

/// A mesh whose scene does not exist until it is asked for.
class EmbreeLazyMesh {
 public:
  EmbreeLazyMesh(const EmbreeMesh& mesh, RTCDevice device, EmbreeQuality quality)
      : mesh_(mesh), device_(device), quality_(quality) {}

  /// Builds it if nobody has; joins whoever does. Threads: any.
  RTCScene scene();

  const EmbreeMesh& mesh() const { return mesh_; }
  bool built() const { return state_.load() == State::kBuilt; }
  std::uint64_t nanoseconds() const { return nanoseconds_; }  ///< Of building, over threads.

 private:
  enum class State : std::uint8_t { kNothing, kMaking, kCommitting, kBuilt };
  void build();

  const EmbreeMesh& mesh_;
  RTCDevice device_;
  EmbreeQuality quality_;
  std::atomic<State> state_ = State::kNothing;
  std::atomic<std::uint64_t> nanoseconds_ = 0;
  EmbreeScenePtr scene_;
};

/// A node with a mesh, as a user geometry of one primitive.
struct EmbreeLazyObject {
  EmbreeLazyMesh* mesh = nullptr;
  unsigned number = 0;  ///< What a hit in it gets as its geometry.
  bool moved = false;
  std::array<float, 12> local_from_frame{};  ///< Where moved; rows.
  RTCBounds bounds{};                        ///< In the frame.
};

/// Of the mesh's vertices, carried to where its node puts it.
RTCBounds embree_bounds(const EmbreeMesh& mesh, const EmbreeMesh::Use& use, bool moved);

/// The geometry, not committed; `object` outlives it.
EmbreeGeometryPtr new_embree_lazy_geometry(RTCDevice device, EmbreeLazyObject& object);

}  // namespace sightline::bench
