// Embree's device, its errors and its memory.
#pragma once

#include <embree3/rtcore.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "proto/result.h"
#include "tests/bench/embree/peer.h"

namespace sightline::bench {

template <auto kRelease>
struct EmbreeRelease {
  template <class T>
  void operator()(T* object) const {
    kRelease(object);
  }
};
using EmbreeDevicePtr = std::unique_ptr<RTCDeviceTy, EmbreeRelease<rtcReleaseDevice>>;
using EmbreeScenePtr = std::unique_ptr<RTCSceneTy, EmbreeRelease<rtcReleaseScene>>;
using EmbreeGeometryPtr = std::unique_ptr<RTCGeometryTy, EmbreeRelease<rtcReleaseGeometry>>;

/// A device that records its errors and its memory. Not movable: Embree keeps its address.
class EmbreeDevice {
 public:
  EmbreeDevice() = default;
  EmbreeDevice(const EmbreeDevice&) = delete;
  EmbreeDevice& operator=(const EmbreeDevice&) = delete;

  /// Errors: kInternal: there is no device.
  Status open(int threads);
  RTCDevice get() const { return device_.get(); }

  /// Errors: kInternal: the first error that the device reported on any thread.
  Status status();

  /// Bytes that Embree holds, as reported to its memory monitor.
  std::int64_t bytes() const { return bytes_; }
  std::int64_t bytes_peak() const { return bytes_peak_; }  ///< Since begin_peak().
  void begin_peak() { bytes_peak_ = bytes_.load(); }

 private:
  static void complain(void* self, RTCError code, const char* text);
  static bool monitor(void* self, std::ptrdiff_t bytes, bool after);

  std::atomic<std::int64_t> bytes_ = 0, bytes_peak_ = 0;
  std::mutex mutex_;
  std::string complaint_;
  EmbreeDevicePtr device_;
};

RTCBuildQuality to_embree(EmbreeQuality quality);

/// Triangles over arrays that are shared with Embree and outlive the geometry. The last vertex is
/// padding: Embree reads 16 bytes at every vertex.
EmbreeGeometryPtr new_embree_triangles(RTCDevice device, EmbreeQuality quality,
                                       std::span<const accel::geometry::Vec3f> padded_vertices,
                                       std::span<const accel::geometry::Face> faces);

}  // namespace sightline::bench
