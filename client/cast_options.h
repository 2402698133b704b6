// Rays, what is asked of them, and their hits.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "client/result.h"
#include "client/types.h"

namespace sightline::client {

/// Which optional columns the rays of a stream have.
struct RayShape {
  bool interval = false;  ///< tmin and tmax
  bool masks = false;
};

/// Rays as columns of arrays, one row per ray. Scalar is `float` or `double`, const for reading.
template <class Scalar>
struct RayColumns {
  using Value = Scalar;
  using Shape = RayShape;
  using Mask = std::conditional_t<std::is_const_v<Scalar>, const std::uint32_t, std::uint32_t>;

  std::span<Scalar> origins;     ///< (n, 3)
  std::span<Scalar> directions;  ///< (n, 3), any length but zero; t is in units of this length
  std::span<Scalar> tmin{};      ///< (n), or empty: 0 for all rays
  std::span<Scalar> tmax{};      ///< (n), or empty: +inf for all rays
  std::span<Mask> masks{};       ///< (n), or empty: all bits set for all rays

  std::size_t size() const { return origins.size() / 3; }
};

/// The size of a column with one bit per ray.
constexpr std::size_t bits_bytes(std::size_t rays) { return (rays + 7) / 8; }

/// Columns of an answer, one row per ray. Only columns that are not empty are requested.
/// sightline.v1.HitField defines the meaning of a row.
template <bool is_const>
struct BasicHitColumns {
  template <class T>
  using Span = std::span<std::conditional_t<is_const, const T, T>>;

  /// (n) in units of the direction's length; +inf: a miss, NaN: a bad ray, -inf: a ray without an
  /// answer
  Span<double> t{};
  Span<std::uint64_t> node{};       ///< (n) 0: a miss
  Span<std::uint32_t> primitive{};  ///< (n) the face of the node's mesh
  Span<float> barycentric{};        ///< (n, 2) weights of vertices 1 and 2
  Span<float> normal{};             ///< (n, 3) unit normal on the front, in world space
  Span<std::uint8_t> hit{};         ///< (n) 0 miss, 1 hit, 2 bad ray, kUnanswered
  Span<std::uint32_t> work{};       ///< (n) steps plus triangle tests, combined with kSawDeferred
  Span<std::uint32_t> count{};  ///< (n) distinct hits; kInvalidCount: a bad ray; kUnansweredCount
  /// (bits_bytes(n)) for kAny: bit i % 8 of byte i / 8 is 1 where ray i hits; a bad ray has 0
  Span<std::uint8_t> hit_bits{};
  /// (bits_bytes(n)) bit i % 8 of byte i / 8 is 1 where ray i has no answer, by
  /// CastOptions::time_budget or allow_partial. In an answer empty if all rays have one
  Span<std::uint8_t> unanswered{};
  Span<double> position{};  ///< (n, 3) where the ray hits, in world space; NaN without a hit
  /// (n) the name of the node, "" without a hit; in an answer its row in HitView::names
  std::conditional_t<is_const, std::span<const std::uint32_t>, std::span<std::string>> name{};
  /// (n) of points, as the next two, with kClosest: `t`, negative inside. 0 has no sign
  Span<double> signed_distance{};
  Span<std::uint8_t> inside{};  ///< (n) 0 outside, 1 inside, 2 bad point, kUnanswered
  /// (n) of CastOptions::side_rays, those that say inside. Neither 0 nor all of them: the surface
  /// has a hole there
  Span<std::uint8_t> votes{};
};
using HitColumns = BasicHitColumns<false>;
/// For a cast of all hits, the columns t, node, primitive, barycentric, normal, position and name
/// have one row per hit, in the order of the rays. `offsets` (n + 1) assigns them: the hits of ray
/// i are the rows offsets[i] up to offsets[i + 1]. A bad ray has no row.
struct HitView : BasicHitColumns<true> {
  std::span<const std::uint32_t> offsets{};
  std::vector<std::string_view> names{};  ///< distinct; the rows of `name` are below its size
};

/// A value of `hit` in a cast of all hits: the ray has more than max_hits hits, and the nearest are
/// here.
inline constexpr std::uint8_t kCutOff = 3;
/// A value of `hit`: there was no time for the ray, or a server that it needs is lost.
inline constexpr std::uint8_t kUnanswered = 4;
/// Values of `count`: a bad ray, and one without an answer.
inline constexpr std::uint32_t kInvalidCount = 0xffffffff;
inline constexpr std::uint32_t kUnansweredCount = kInvalidCount - 1;
/// A bit of `work`: the ray met a cell that is not built.
inline constexpr std::uint32_t kSawDeferred = 0x80000000;

/// Which columns an answer contains.
struct HitFields {
  bool t = false;
  bool node = false;
  bool primitive = false;
  bool barycentric = false;
  bool normal = false;
  bool hit = false;
  bool work = false;
  bool count = false;
  bool hit_bits = false;
  bool position = false;
  bool name = false;
  bool signed_distance = false;
  bool inside = false;
  bool votes = false;

  bool operator==(const HitFields&) const = default;

  bool has_sides() const { return signed_distance || inside || votes; }
  /// Whether sides are asked for, and nothing that needs a distance.
  bool are_sides_alone() const {
    HitFields others = *this;
    others.inside = others.votes = false;
    return has_sides() && others == HitFields();
  }
};

/// What is asked about each ray. All kinds see the same hits, whatever the limits, masks and other
/// options are.
enum class QueryKind : std::uint8_t {
  kClosest,  ///< the hit with the smallest (t, node, primitive)
  kAny,      ///< whether there is any hit: answers `hit`, `hit_bits` and `work`
  kCount,    ///< the number of distinct (node, primitive) hit: answers `count`, `hit` and `work`
  kAll,      ///< every hit, ordered by (t, node, primitive), each (node, primitive) once
};

/// Which hits a cast ignores, whatever its kind. The front of a triangle is the side that shows its
/// vertices counterclockwise in the mesh's own frame: a mirrored node keeps its outside.
enum class Culling : std::uint8_t { kNone, kBack, kFront };

/// How much of the trees a cast may build.
enum class BuildMode : std::uint8_t {
  kServerPolicy,
  kLazy,       ///< the cells that rays enter
  kFull,       ///< everything, before the first ray
  kNone,       ///< nothing; unbuilt cells are searched triangle by triangle
  kBuiltOnly,  ///< nothing; unbuilt cells are skipped: shows what exists, and is no valid query
};

/// What decides whether a point is inside; docs/distance_rule.md says which rule suits which mesh.
enum class SideRule : std::uint8_t {
  kParity,   ///< a ray from the point crosses an odd number of faces
  kWinding,  ///< the ray does not meet as many faces from behind as from the front
  kNormal,   ///< the point is behind the nearest face, or those that share the nearest edge or
             ///< corner
};

/// The most rays that may decide together.
inline constexpr std::uint32_t kMaxSideRays = 63;

struct CastOptions {
  QueryKind kind = QueryKind::kClosest;
  BuildMode build = BuildMode::kServerPolicy;
  Culling culling = Culling::kNone;
  /// Only this node and its descendants are visible. 0: all nodes. Errors: kNotFound, as for
  /// `exclude`.
  std::uint64_t root = 0;
  /// These nodes and their descendants are not visible.
  std::vector<std::uint64_t> exclude{};
  /// Only nodes that have one of these labels and their descendants are visible. Empty: all nodes.
  std::vector<LabelMatch> only_labels{};
  /// Nodes that have one of these labels and their descendants are not visible.
  std::vector<LabelMatch> exclude_labels{};
  /// How many hits kAll keeps per ray, the nearest first. 0: the server's default.
  std::uint32_t max_hits = 0;
  /// Of points, as side_rays: what signed_distance, inside and votes go by. Not set: kParity.
  std::optional<SideRule> side_rule{};
  /// kParity, kWinding: the number of rays whose majority decides: odd, at most kMaxSideRays. 0: 1.
  std::uint32_t side_rays = 0;
  /// Time for the cast on the server, its waiting there included. Rays that have no answer by then
  /// are marked, and CastReport counts them. What was built for them stays: the next cast goes on
  /// from there. 0: no bound.
  std::chrono::milliseconds time_budget{0};
  /// Where servers answer for parts of the scene and one of them does not: rays whose answers it
  /// could change are marked, too, and the cast succeeds. Otherwise it fails with kUnavailable.
  bool allow_partial = false;
  /// The revision that answers.
  Consistency consistency{};
  /// A key for balancers that keep each part of a scene on a server of its own, as they keep scenes
  /// apart: equal keys go to the same server. For example, where the sensor is, in coarse steps.
  /// Visible ASCII; empty: all of the scene is one part.
  std::string route_key{};
  /// Cancels the cast, which then fails with kCancelled.
  std::stop_token stop{};
};

/// Sums over all rays of the cast.
struct CastReport {
  std::uint64_t revision = 0;  ///< the revision of the scene that answered every ray
  std::string token{};         ///< that revision's, for Consistency::at_least
  std::uint64_t rays = 0;
  /// rays with a hit, for every kind; 0 where HitFields::are_sides_alone(), as no face is looked
  /// for
  std::uint64_t hits = 0;
  std::uint64_t invalid = 0;
  std::uint64_t unanswered = 0;  ///< rays left unanswered; CastOptions::time_budget, allow_partial
  std::uint64_t hits_found = 0;  ///< kCount: the sum of the counts; kAll: the hits listed
  std::uint64_t rays_cut_off = 0;  ///< kAll: rays with more than max_hits hits
  std::uint64_t traversal_steps = 0;
  std::uint64_t triangle_tests = 0;
  std::uint64_t instances_entered = 0;
  std::uint64_t cells_expanded = 0;
  std::uint64_t queue_us = 0;  ///< time in the server's queue
  std::uint64_t build_us = 0;  ///< time to build trees, summed over threads
  std::uint64_t trace_us = 0;  ///< wall time from start to end, building included
};

inline constexpr std::size_t kRaysPerMessage = 8192;
/// A request for generated rays, which take no room in a message, may have this many.
inline constexpr std::size_t kGeneratedRaysPerMessage = 16384;
inline constexpr std::size_t kMessagesInFlight = 4;

/// Writes the next k rows into the first rows of `buffer`, which has kRaysPerMessage rows, and
/// returns k. 0 ends the stream. An error also ends it, and the cast returns it. Called in order,
/// on a thread of the cast. Columns are RayColumns or PointColumns.
template <class Columns>
using RowSource = std::function<Result<std::size_t>(const Columns& buffer)>;
template <class Scalar>
using RaySource = RowSource<RayColumns<Scalar>>;

/// Takes the answers to `count` rays, beginning with ray `first`, in order, on the calling thread.
/// For kAll they have `offsets` and `hit`. An error ends the cast, which returns it.
using HitSink = std::function<Status(std::uint64_t first, std::size_t count, const HitView& hits)>;

/// All hits of many rays: one row per hit, in the order of the rays and nearest first. Columns that
/// were not requested are empty. The columns mean the same as in HitColumns.
struct AllHits {
  /// (n + 1) the hits of ray i are rows offsets[i] to offsets[i + 1]
  std::vector<std::uint64_t> offsets;
  std::vector<std::uint8_t> hit;    ///< (n) 0 miss, 1 hit, 2 bad ray, kCutOff; always present
  std::vector<std::uint32_t> work;  ///< (n)
  std::vector<double> t;
  std::vector<std::uint64_t> node;
  std::vector<std::uint32_t> primitive;
  std::vector<float> barycentric;
  std::vector<float> normal;
  std::vector<double> position;
  std::vector<std::string> name;
  CastReport report;

  /// Appends the answers in `hits`, which has offsets for its rays.
  void append(const HitView& hits);
};

}  // namespace sightline::client
