// Rays in the layout of one of Embree's entry points, and the calls themselves.
#pragma once

#include <embree3/rtcore.h>
#include <tbb/cache_aligned_allocator.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "accel/geometry/ray.h"
#include "scenegraph/model/affine.h"
#include "scenegraph/trace.h"

namespace sightline::bench {

/// How rays are passed: a packet of `lanes` rays (1: a single ray), or single rays as a stream
/// (rtcIntersect1M).
struct EmbreeEntry {
  unsigned lanes = 1;
  bool stream = false;
  bool coherent = false;

  std::string name(bool any) const;
};

/// Single rays ignore the flag.
inline constexpr std::array<EmbreeEntry, 7> kEmbreeEntries{{{1, false, false},
                                                            {8, false, true},
                                                            {8, false, false},
                                                            {16, false, true},
                                                            {16, false, false},
                                                            {1, true, true},
                                                            {1, true, false}}};

/// Rays a task, as in our own tracing.
inline constexpr std::size_t kEmbreeBlock = scenegraph::kRaysPerBlock;

class EmbreeRays {
 public:
  EmbreeRays(const EmbreeEntry& entry, bool any) : entry_(entry), any_(any) {}

  /// Writes the rays, transformed by `frame` in double and then rounded to float. Parallel.
  void fill(std::span<const accel::geometry::Ray> rays, const scenegraph::model::Affine& frame);

  /// Traces rays [first, first + count) in blocks, in parallel; first is a multiple of the lanes.
  void trace(RTCScene scene, std::size_t first, std::size_t count);

  struct Answer {
    bool hit = false;
    float t = 0;
    std::uint32_t primitive = 0, geometry = 0, instance = 0;  ///< Embree's numbers.
  };
  Answer answer(std::size_t ray) const;

 private:
  // Twelve words of a ray; unless `any`, eight words of a hit after the packet's rays.
  std::size_t words() const { return any_ ? 12 : 20; }
  const float* packet(std::size_t ray) const {
    return words_.data() + ray / entry_.lanes * entry_.lanes * words();
  }
  float* packet(std::size_t ray) {
    return words_.data() + ray / entry_.lanes * entry_.lanes * words();
  }
  void trace_block(RTCScene scene, std::size_t first, std::size_t count);

  EmbreeEntry entry_;
  bool any_;
  std::vector<float, tbb::cache_aligned_allocator<float>> words_;
};

/// One of Embree's scenes, the rays' transformation to it, and the nodes of its geometries.
struct EmbreeTarget {
  RTCScene scene;
  EmbreeEntry entry;
  const scenegraph::model::Affine& frame;
  std::span<const std::uint64_t> nodes;  ///< By the number of an instance, or of a geometry.
  bool by_geometry = false;              ///< Instance numbers are ignored.
};

/// The fastest entry point for blocks of these rays. `instances`: whether the scene has instances.
EmbreeEntry fastest_entry(RTCScene scene, std::span<const accel::geometry::Ray> rays,
                          const scenegraph::model::Affine& frame, bool any, bool instances);

/// As EmbreePeer::trace.
double trace_embree(const EmbreeTarget& target, std::span<const accel::geometry::Ray> rays,
                    bool any, std::span<accel::geometry::Hit> hits, std::size_t batch);

}  // namespace sightline::bench
