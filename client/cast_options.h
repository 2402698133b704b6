// Rays, what is asked of them, and their hits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <type_traits>
#include <vector>

#include "client/result.h"
#include "client/types.h"

namespace sightline::client {

/// Scalar is `float` or `double`, const for reading.
template <class Scalar>
struct RayColumns {
  using Mask = std::conditional_t<std::is_const_v<Scalar>, const std::uint32_t, std::uint32_t>;

  std::span<Scalar> origins;     ///< (n, 3)
  std::span<Scalar> directions;  ///< (n, 3), any length but zero; t counts in this length.
  std::span<Scalar> tmin{};      ///< (n), or empty: 0
  std::span<Scalar> tmax{};      ///< (n), or empty: +inf
  std::span<Mask> masks{};       ///< (n), or empty: all ones

  std::size_t size() const { return origins.size() / 3; }
};

/// Columns of an answer. Non-empty ones are asked for; the meaning of a row is that of
/// sightline.v1.HitField.
template <bool is_const>
struct BasicHitColumns {
  template <class T>
  using Span = std::span<std::conditional_t<is_const, const T, T>>;

  Span<double> t{};                 ///< (n) in lengths of the direction; miss +inf, bad ray NaN
  Span<std::uint64_t> node{};       ///< (n) 0 for a miss
  Span<std::uint32_t> primitive{};  ///< (n) face of the node's mesh
  Span<float> barycentric{};        ///< (n, 2) weights of vertices 1 and 2
  Span<float> normal{};             ///< (n, 3) geometric, unit, by winding, world space
  Span<std::uint8_t> hit{};         ///< (n) 0 miss, 1 hit, 2 bad ray
  Span<std::uint32_t> work{};       ///< (n) steps + triangle tests; kMetUnbuilt is set beside them
  Span<std::uint32_t> count{};      ///< (n) distinct hits; kInvalidCount for a bad ray
};
using HitColumns = BasicHitColumns<false>;
/// Where all hits are asked for, t, node, primitive, barycentric and normal have a row a hit, in
/// the order of the rays, and `offsets` (n + 1) says which: those of ray i are rows offsets[i] up
/// to offsets[i + 1]. A bad ray has none.
struct HitView : BasicHitColumns<true> {
  std::span<const std::uint32_t> offsets{};
};

/// In `hit`, where all hits are asked for: there are more than max_hits, the nearest are here.
inline constexpr std::uint8_t kCutOff = 3;
/// In `count`: a bad ray.
inline constexpr std::uint32_t kInvalidCount = 0xffffffff;
/// In `work`: the ray met a cell that is not built.
inline constexpr std::uint32_t kMetUnbuilt = 0x80000000;

/// Which columns an answer is to have.
struct HitFields {
  bool t = false;
  bool node = false;
  bool primitive = false;
  bool barycentric = false;
  bool normal = false;
  bool hit = false;
  bool work = false;
  bool count = false;
};

/// All kinds see the same hits, whatever limits, masks and other options are set.
enum class QueryKind : std::uint8_t {
  kClosest,  ///< The hit with the smallest (t, node, primitive).
  kAny,      ///< Whether there is a hit at all: answers `hit`, and `work`.
  kCount,    ///< How many distinct (node, primitive) are hit: answers `count`, `hit` and `work`.
  kAll,      ///< Every hit by (t, node, primitive), each (node, primitive) once.
};

/// Hits that do not exist for a cast, whatever its kind. The front of a triangle is the side that
/// shows its corners counterclockwise in scene coordinates.
enum class Culling : std::uint8_t { kNone, kBack, kFront };

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
  Culling culling = Culling::kNone;
  /// Only this node and those under it exist; 0: all. Errors: kNotFound, as for `exclude`.
  std::uint64_t root = 0;
  /// These nodes and those under them do not.
  std::vector<std::uint64_t> exclude{};
  /// Of kAll: for each ray, the nearest are kept. 0: as the server has it.
  std::uint32_t max_hits = 0;
  /// The revision that answers.
  Consistency consistency{};
  /// Cancels the cast, which then ends with kCancelled.
  std::stop_token stop{};
};

/// Sums over the cast.
struct CastReport {
  std::uint64_t revision = 0;  ///< Of the scene, the one that answered every ray.
  std::string token{};         ///< Of that revision, for Consistency::at_least.
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;  ///< Rays with a hit, whatever the kind.
  std::uint64_t invalid = 0;
  std::uint64_t hits_found = 0;    ///< kCount: the sum; kAll: hits listed.
  std::uint64_t rays_cut_off = 0;  ///< kAll: rays with more hits than max_hits.
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

/// Takes the answers to `count` rays from number `first` on, in order, on the thread that casts; of
/// kAll with `offsets` and `hit`. An error ends the cast and is what it returns.
using HitSink = std::function<Status(std::uint64_t first, std::size_t count, const HitView& hits)>;

/// A row a hit, in the order of the rays and nearest first. Columns that were not asked for are
/// empty; the meaning of a row is that of HitColumns.
struct AllHits {
  std::vector<std::uint64_t> offsets;  ///< (n + 1) the hits of ray i: offsets[i] to offsets[i + 1]
  std::vector<std::uint8_t> hit;       ///< (n) 0 miss, 1 hit, 2 bad ray, kCutOff; always there
  std::vector<std::uint32_t> work;     ///< (n)
  std::vector<double> t;
  std::vector<std::uint64_t> node;
  std::vector<std::uint32_t> primitive;
  std::vector<float> barycentric;
  std::vector<float> normal;
  CastReport report;

  /// Adds the answers to as many rays as `hits` has offsets for.
  void append(const HitView& hits);
};

}  // namespace sightline::client
