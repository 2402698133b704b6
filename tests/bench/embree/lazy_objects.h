// Objects that Embree builds when the first ray reaches them.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "tests/bench/embree/device.h"
#include "tests/bench/embree/layout.h"

namespace sightline::bench {

/// A mesh whose scene is built on first use.
class EmbreeLazyMesh {
 public:
  EmbreeLazyMesh(const EmbreeMesh& mesh, RTCDevice device, EmbreeQuality quality)
      : mesh_(mesh), device_(device), quality_(quality) {}

  /// Builds the scene, or joins the thread that is building it. Threads: any.
  RTCScene scene();

  const EmbreeMesh& mesh() const { return mesh_; }
  bool built() const { return state_.load() == State::kBuilt; }
  std::uint64_t nanoseconds() const {
    return nanoseconds_;
  }  ///< Time spent building, summed over threads.

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
  unsigned number = 0;  ///< The geometry number that its hits report.
  bool moved = false;
  std::array<float, 12> local_from_frame{};  ///< Rows; set if the node is transformed.
  RTCBounds bounds{};                        ///< In the frame.
};

/// Bounds of the mesh's vertices, transformed by its node.
RTCBounds embree_bounds(const EmbreeMesh& mesh, const EmbreeMesh::Use& use, bool moved);

/// Creates the geometry without committing it; `object` must outlive it.
EmbreeGeometryPtr new_embree_lazy_geometry(RTCDevice device, EmbreeLazyObject& object);

}  // namespace sightline::bench
