// What is asked of rays, and what answering them has cost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <stop_token>

#include "client/rays.h"
#include "client/result.h"

namespace sightline::client {

enum class QueryKind : std::uint8_t {
  kClosest,  ///< The hit with the smallest (t, node, primitive).
  kAny,      ///< Whether there is a hit at all: answers `hit`, and `work`.
};

/// How much tree a cast may grow.
enum class BuildMode : std::uint8_t {
  kServerPolicy,
  kLazy,       ///< What the rays enter.
  kFull,       ///< Everything, before the first ray.
  kNone,       ///< Nothing; what is not built is searched triangle by triangle.
  kBuiltOnly,  ///< Nothing; what is not built is passed over: shows what exists, answers no query.
};

struct CastOptions {
  QueryKind kind = QueryKind::kClosest;
  BuildMode build = BuildMode::kServerPolicy;
  /// Cancels the cast, which then ends with kCancelled.
  std::stop_token stop{};
};

/// Sums over the cast.
struct CastReport {
  std::uint64_t revision = 0;  ///< Of the scene, the one that answered every ray.
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;
  std::uint64_t invalid = 0;
  std::uint64_t traversal_steps = 0;
  std::uint64_t triangle_tests = 0;
  std::uint64_t instances_entered = 0;
  std::uint64_t cells_expanded = 0;
  std::uint64_t queue_us = 0;  ///< Waiting in the server's queue.
  std::uint64_t build_us = 0;  ///< Growing trees, over threads.
  std::uint64_t trace_us = 0;  ///< From begun to done, building included.
};

inline constexpr std::size_t kRaysPerMessage = 8192;
inline constexpr std::size_t kMessagesInFlight = 4;

/// Which of the optional columns the rays of a stream have.
struct RayShape {
  bool interval = false;  ///< tmin and tmax
  bool masks = false;
};

/// Fills the first k rows of `room`, which has kRaysPerMessage of them, and returns k; 0 ends the
/// stream. An error ends it too, and is what the cast returns. Called in order, on a thread of the
/// cast.
template <class Scalar>
using RaySource = std::function<Result<std::size_t>(const RayColumns<Scalar>& room)>;

/// Takes the answers to `count` rays from number `first` on, in order, on the thread that casts. An
/// error ends the cast and is what it returns.
using HitSink = std::function<Status(std::uint64_t first, std::size_t count, const HitView& hits)>;

}  // namespace sightline::client
