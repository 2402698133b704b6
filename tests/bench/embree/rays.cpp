// Rays in the layout of one of Embree's entry points.
#include "tests/bench/embree/rays.h"

#include <pmmintrin.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <xmmintrin.h>

#include <algorithm>
#include <limits>

#include "tests/bench/verbs/stopwatch.h"

namespace sightline::bench {
namespace {

// The layouts that words() and the packets' offsets assume.
static_assert(sizeof(RTCRay) == 12 * 4 && sizeof(RTCRayHit) == 20 * 4);
static_assert(sizeof(RTCRayHit8) == 8 * 20 * 4 && sizeof(RTCRayHit16) == 16 * 20 * 4);

// The denormal mode that Embree advises for tracing threads; the old one is restored afterwards.
class FlushDenormals {
 public:
  FlushDenormals() : before_(_mm_getcsr()) {
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
  }
  ~FlushDenormals() { _mm_setcsr(before_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned before_;
};

}  // namespace

std::string EmbreeEntry::name(bool any) const {
  std::string name = any ? "rtcOccluded" : "rtcIntersect";
  name += stream ? "1M" : std::to_string(lanes);
  if (lanes == 1 && !stream) return name;
  return name + (coherent ? " coherent" : " incoherent");
}

void EmbreeRays::fill(std::span<const accel::geometry::Ray> rays,
                      const scenegraph::model::Affine& frame) {
  const unsigned lanes = entry_.lanes;
  const std::size_t padded = (rays.size() + lanes - 1) / lanes * lanes;
  words_.resize(padded * words());
  tbb::parallel_for(std::size_t{0}, padded, [&](std::size_t i) {
    const accel::geometry::Ray& ray = rays[std::min(i, rays.size() - 1)];
    const accel::geometry::Vec3d o = frame.point(ray.origin), d = frame.direction(ray.direction);
    auto* r = reinterpret_cast<RTCRayN*>(packet(i));
    const auto lane = static_cast<unsigned>(i % lanes);
    RTCRayN_org_x(r, lanes, lane) = static_cast<float>(o.x);
    RTCRayN_org_y(r, lanes, lane) = static_cast<float>(o.y);
    RTCRayN_org_z(r, lanes, lane) = static_cast<float>(o.z);
    RTCRayN_tnear(r, lanes, lane) = static_cast<float>(ray.tmin);
    RTCRayN_dir_x(r, lanes, lane) = static_cast<float>(d.x);
    RTCRayN_dir_y(r, lanes, lane) = static_cast<float>(d.y);
    RTCRayN_dir_z(r, lanes, lane) = static_cast<float>(d.z);
    RTCRayN_time(r, lanes, lane) = 0;
    RTCRayN_tfar(r, lanes, lane) = static_cast<float>(ray.tmax);
    RTCRayN_mask(r, lanes, lane) = ~0u;
    RTCRayN_id(r, lanes, lane) = static_cast<unsigned>(i);
    RTCRayN_flags(r, lanes, lane) = 0;
    if (any_) return;
    RTCHitN* h = RTCRayHitN_HitN(reinterpret_cast<RTCRayHitN*>(r), lanes);
    RTCHitN_primID(h, lanes, lane) = RTC_INVALID_GEOMETRY_ID;
    RTCHitN_geomID(h, lanes, lane) = RTC_INVALID_GEOMETRY_ID;
    RTCHitN_instID(h, lanes, lane, 0) = RTC_INVALID_GEOMETRY_ID;
  });
}

void EmbreeRays::trace(RTCScene scene, std::size_t first, std::size_t count) {
  const std::size_t blocks = (count + kEmbreeBlock - 1) / kEmbreeBlock;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks, 1), [&](const auto& range) {
    const FlushDenormals flush;
    for (std::size_t b = range.begin(); b != range.end(); ++b) {
      trace_block(scene, first + b * kEmbreeBlock,
                  std::min(kEmbreeBlock, count - b * kEmbreeBlock));
    }
  });
}

void EmbreeRays::trace_block(RTCScene scene, std::size_t first, std::size_t count) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags =
      entry_.coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  if (entry_.stream) {
    const auto n = static_cast<unsigned>(count);
    if (any_) {
      rtcOccluded1M(scene, &context, reinterpret_cast<RTCRay*>(packet(first)), n, sizeof(RTCRay));
    } else {
      rtcIntersect1M(scene, &context, reinterpret_cast<RTCRayHit*>(packet(first)), n,
                     sizeof(RTCRayHit));
    }
    return;
  }
  alignas(64) std::array<int, 16> valid;
  valid.fill(-1);
  for (std::size_t i = 0; i < count; i += entry_.lanes) {
    float* p = packet(first + i);
    if (count - i < entry_.lanes) {
      std::fill(valid.begin() + static_cast<std::ptrdiff_t>(count - i), valid.end(), 0);
    }
    switch (entry_.lanes) {
      case 1:
        any_ ? rtcOccluded1(scene, &context, reinterpret_cast<RTCRay*>(p))
             : rtcIntersect1(scene, &context, reinterpret_cast<RTCRayHit*>(p));
        break;
      case 8:
        any_ ? rtcOccluded8(valid.data(), scene, &context, reinterpret_cast<RTCRay8*>(p))
             : rtcIntersect8(valid.data(), scene, &context, reinterpret_cast<RTCRayHit8*>(p));
        break;
      default:
        any_ ? rtcOccluded16(valid.data(), scene, &context, reinterpret_cast<RTCRay16*>(p))
             : rtcIntersect16(valid.data(), scene, &context, reinterpret_cast<RTCRayHit16*>(p));
    }
  }
}

EmbreeRays::Answer EmbreeRays::answer(std::size_t ray) const {
  // Embree's accessors are not const.
  auto* r = reinterpret_cast<RTCRayN*>(const_cast<float*>(packet(ray)));
  const unsigned lanes = entry_.lanes;
  const auto lane = static_cast<unsigned>(ray % lanes);
  Answer answer;
  answer.t = RTCRayN_tfar(r, lanes, lane);
  if (any_) {
    answer.hit = answer.t == -std::numeric_limits<float>::infinity();
    return answer;
  }
  RTCHitN* h = RTCRayHitN_HitN(reinterpret_cast<RTCRayHitN*>(r), lanes);
  answer.geometry = RTCHitN_geomID(h, lanes, lane);
  answer.primitive = RTCHitN_primID(h, lanes, lane);
  answer.instance = RTCHitN_instID(h, lanes, lane, 0);
  answer.hit = answer.geometry != RTC_INVALID_GEOMETRY_ID;
  return answer;
}

EmbreeEntry fastest_entry(RTCScene scene, std::span<const accel::geometry::Ray> rays,
                          const scenegraph::model::Affine& frame, bool any, bool instances) {
  // Whole blocks, to keep rays coherent, from all parts of the batch.
  constexpr std::size_t kTrialRays = 65'536, kTrials = 3;
  std::vector<accel::geometry::Ray> trial;
  const std::size_t step = std::max<std::size_t>(rays.size() / kTrialRays, 1) * kEmbreeBlock;
  for (std::size_t first = 0; first < rays.size(); first += step) {
    const auto block = rays.subspan(first, std::min(kEmbreeBlock, rays.size() - first));
    trial.insert(trial.end(), block.begin(), block.end());
  }
  EmbreeEntry fastest;
  if (trial.empty()) return fastest;
  double best = std::numeric_limits<double>::infinity();
  for (const EmbreeEntry& entry : kEmbreeEntries) {
    // Embree 3.13.5 never returns from some coherent occlusion packets under instances.
    if (any && entry.coherent && instances) continue;
    EmbreeRays buffer(entry, any);
    for (std::size_t repeat = 0; repeat < kTrials; ++repeat) {
      buffer.fill(trial, frame);
      const Stopwatch clock;
      buffer.trace(scene, 0, trial.size());
      const double seconds = clock.seconds();
      if (seconds >= best) continue;
      best = seconds;
      fastest = entry;
    }
  }
  return fastest;
}

double trace_embree(const EmbreeTarget& target, std::span<const accel::geometry::Ray> rays,
                    bool any, std::span<accel::geometry::Hit> hits, std::size_t batch) {
  if (rays.empty()) return 0;
  if (batch == 0) batch = rays.size();
  EmbreeRays buffer(target.entry, any);
  double seconds = 0;
  for (std::size_t first = 0; first < rays.size(); first += batch) {
    const std::size_t count = std::min(batch, rays.size() - first);
    buffer.fill(rays.subspan(first, count), target.frame);
    const Stopwatch clock;
    buffer.trace(target.scene, 0, count);
    seconds += clock.seconds();
    for (std::size_t i = 0; i < count; ++i) {
      const EmbreeRays::Answer answer = buffer.answer(i);
      accel::geometry::Hit& hit = hits[first + i];
      hit = {};
      if (!answer.hit) continue;
      hit.state = accel::geometry::HitState::kHit;
      if (any) continue;
      hit.t = static_cast<double>(answer.t);
      hit.primitive = answer.primitive;
      const bool by_geometry = target.by_geometry || answer.instance == RTC_INVALID_GEOMETRY_ID;
      hit.node = target.nodes[by_geometry ? answer.geometry : answer.instance];
    }
  }
  return seconds;
}

}  // namespace sightline::bench
