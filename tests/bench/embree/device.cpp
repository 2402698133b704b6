// Embree's device, its errors and its memory.
#include "tests/bench/embree/device.h"

namespace sightline::bench {

Status EmbreeDevice::open(int threads) {
  device_.reset(rtcNewDevice(("threads=" + std::to_string(threads)).c_str()));
  if (!device_) return Error{Code::kInternal, "Embree: no device", "EMBREE"};
  rtcSetDeviceErrorFunction(device_.get(), &EmbreeDevice::complain, this);
  rtcSetDeviceMemoryMonitorFunction(device_.get(), &EmbreeDevice::monitor, this);
  return {};
}

Status EmbreeDevice::status() {
  const std::lock_guard lock(mutex_);
  if (complaint_.empty()) return {};
  return Error{Code::kInternal, complaint_, "EMBREE"};
}

void EmbreeDevice::complain(void* self, RTCError code, const char* text) {
  auto& device = *static_cast<EmbreeDevice*>(self);
  const std::lock_guard lock(device.mutex_);
  if (!device.complaint_.empty()) return;
  device.complaint_ =
      "Embree: error " + std::to_string(static_cast<int>(code)) + ": " + (text ? text : "");
}

bool EmbreeDevice::monitor(void* self, std::ptrdiff_t bytes, bool) {
  auto& device = *static_cast<EmbreeDevice*>(self);
  const std::int64_t now = device.bytes_ += bytes;
  std::int64_t peak = device.bytes_peak_;
  while (now > peak && !device.bytes_peak_.compare_exchange_weak(peak, now)) {
  }
  return true;
}

RTCBuildQuality to_embree(EmbreeQuality quality) {
  switch (quality) {
    case EmbreeQuality::kLow:
      return RTC_BUILD_QUALITY_LOW;
    case EmbreeQuality::kMedium:
      return RTC_BUILD_QUALITY_MEDIUM;
    case EmbreeQuality::kHigh:
      break;
  }
  return RTC_BUILD_QUALITY_HIGH;
}

EmbreeGeometryPtr new_embree_triangles(RTCDevice device, EmbreeQuality quality,
                                       std::span<const accel::geometry::Vec3f> padded_vertices,
                                       std::span<const accel::geometry::Face> faces) {
  EmbreeGeometryPtr geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  rtcSetGeometryBuildQuality(geometry.get(), to_embree(quality));
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             padded_vertices.data(), 0, sizeof(accel::geometry::Vec3f),
                             padded_vertices.size() - 1);
  rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             faces.data(), 0, sizeof(accel::geometry::Face), faces.size());
  rtcCommitGeometry(geometry.get());
  return geometry;
}

}  // namespace sightline::bench
