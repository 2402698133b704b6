// The way of a batch of rays through one revision. Start reading here.
//
//   trace_blocks   pins the trees of the revision and, for each block of rays, an epoch
//   cast_rays      takes packets of rays through the trees, their instances and the meshes of those
//   cast_ray       does so with one ray that a packet leaves
//   trace, count_hits, list_hits   return the hits, their number or all of them
//
// Deferred cells on the way are expanded, searched or skipped as TraceOptions::growth says: see
// accel/lazy/walk_lazily.h.
#include "scenegraph/trace.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <optional>
#include <string>
#include <utility>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/last_use.h"
#include "scenegraph/query/packet_caster.h"
#include "scenegraph/query/pencil_caster.h"
#include "scenegraph/query/ray_blocks.h"
#include "scenegraph/query/ray_caster.h"
#include "scenegraph/query/scouts.h"

namespace sightline::scenegraph {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitColumns;
using accel::geometry::Ray;
using accel::geometry::RayColumns;
using accel::kdtree::EpochPin;
using accel::lazy::WhenPending;
using accel::wide::kLanes;
using query::PacketCaster;
using query::RayBlock;
using query::RayCaster;
using query::TreeEntry;

/// One ray, with its answer in the caster. False: it is cancelled, or suspended because it needs a
/// large cell that other threads are building.
bool cast_ray(RayCaster& caster, QueryKind kind, const Ray& ray, WhenPending when_pending) {
  caster.begin(kind, ray, when_pending);
  for (TreeEntry* tree : caster.trees_by_entry()) {
    caster.walk_instances(*tree, [&](const instances::Instance& instance) {
      if (caster.enter_frame(instance)) caster.ask_mesh(instance, *tree);
    });
    if (caster.is_done()) break;
  }
  return caster.end();
}

/// Runs answer(OpenTrees, RayBlock), which returns its TraceStats, for every block of a batch.
template <class Answer>
Result<TraceStats> trace_blocks(const revision::Snapshot& snapshot, QueryKind kind,
                                const RayColumns& rays, std::size_t rays_per_block,
                                const TraceOptions& options, const Answer& answer) {
  accel::kdtree::begin_batch();
  Result<TraceStats> built = options.growth == Growth::kFull
                                 ? build_all(snapshot, options.cancelled, options.progress)
                                 : TraceStats{};
  if (!built && options.partial && built.error().code == Code::kCancelled) return TraceStats{};
  if (!built) return built;
  const instances::OpenTrees trees = snapshot.trees();
  const auto answer_all = [&] {
    if (options.growth == Growth::kDemand)
      *built += query::grow_for_batch(trees, rays, kind, options, cast_ray);
    return query::run_blocks(rays.size, rays_per_block, options,
                             [&](const RayBlock& block) { return answer(trees, block); });
  };
  Result<TraceStats> traced = query::or_error(answer_all);
  if (traced) *traced += *built;
  return traced;
}

/// The rays of a block that packets have answered: a bit for each ray of a packet.
using Answered = std::array<std::uint32_t, kRaysPerBlock / kLanes>;

bool has(const Answered& answered, std::size_t ray) {
  return (answered[ray / kLanes] >> ray % kLanes & 1) != 0;
}

/// Casts the other rays of a block one by one and calls keep(i, caster) where the answer to rays[i]
/// is in the caster.
template <class Keep>
TraceStats cast_alone(EpochPin& pin, const instances::OpenTrees& trees, QueryKind kind,
                      const RayColumns& rays, const RayBlock& block, const Answered& answered,
                      const TraceOptions& options, const Keep& keep) {
  RayCaster caster(pin, trees, options);
  answer_block(caster, block, options.cancelled, [&](std::size_t i, WhenPending when_pending) {
    if (has(answered, i - block.first)) return true;
    const Ray ray = rays[i];
    const bool done = cast_ray(caster, kind, ray, when_pending);
    if (done) keep(i, caster);
    return done;
  });
  return caster.stats();
}

/// Asks for memory that is read later, or written. Always inline: GCC drops calls of functions that
/// only prefetch.
template <bool kWritten>
[[gnu::always_inline]] inline void prefetch(const std::byte* begin, const std::byte* end) {
  constexpr std::ptrdiff_t kLine = 64;
  for (; begin < end; begin += kLine) __builtin_prefetch(begin, kWritten);
}

/// Pencils of the rays of a batch, which write their hits.
class HitPencils {
 public:
  HitPencils(EpochPin& pin, const instances::OpenTrees& trees, const TraceOptions& options,
             const RayColumns& rays, const HitColumns& hits)
      : caster_(pin, trees, options, rays, hits), rays_(rays), hits_(hits) {}

  /// Returns a bit for each packet of these rays that is answered.
  std::uint32_t cast(std::size_t first, std::size_t count) {
    // Structs begin with these columns; the processor foresees narrower ones.
    const std::size_t next = first + count, end = std::min(next + query::kPencilRays, rays_.size);
    prefetch<false>(rays_.origin[0].at(next), rays_.origin[0].at(end));
    if (hits_.t.is_asked()) prefetch<true>(hits_.t.at(next), hits_.t.at(end));
    return caster_.cast(first, count);
  }
  const TraceStats& stats() const { return caster_.stats(); }

 private:
  query::PencilCaster caster_;
  const RayColumns& rays_;
  const HitColumns& hits_;
};

struct NoPencils {
  static std::uint32_t cast(std::size_t, std::size_t) { return 0; }
  static TraceStats stats() { return {}; }
};

/// Casts every ray, in packets as far as those go, or in make_pencils(EpochPin, OpenTrees). Calls
/// keep(first, answered, PacketCaster) where the answers to the rays from the first on are in the
/// caster that have a bit in `answered`, and keep_alone(i, RayCaster) for each of the others.
template <class MakePencils, class Keep, class KeepAlone>
Result<TraceStats> cast_rays(const revision::Snapshot& snapshot, QueryKind kind,
                             const RayColumns& rays, const TraceOptions& options,
                             const MakePencils& make_pencils, const Keep& keep,
                             const KeepAlone& keep_alone) {
  const auto answer = [&](const instances::OpenTrees& trees, const RayBlock& block) {
    EpochPin pin;
    PacketCaster caster(pin, trees, kind, options);
    auto pencils = make_pencils(pin, trees);
    Answered answered{};
    bool all = true;
    std::uint32_t in_pencils = 0;  // a bit for each of the next packets
    for (std::size_t i = block.first; i < block.end && !is_cancelled(options.cancelled);
         i += kLanes, in_pencils >>= 1) {
      if ((i - block.first) % query::kPencilRays == 0)
        in_pencils = pencils.cast(i, std::min(query::kPencilRays, block.end - i));
      const std::size_t count = std::min(kLanes, block.end - i);
      const auto every = static_cast<std::uint32_t>((std::uint64_t{1} << count) - 1);
      std::uint32_t done = every;
      if ((in_pencils & 1) == 0) {
        done = caster.cast(rays, {i, count});
        keep(i, done, caster);
      }
      answered[(i - block.first) / kLanes] = done;
      all &= done == every;
    }
    TraceStats stats = caster.stats();
    stats += pencils.stats();
    if (!all) stats += cast_alone(pin, trees, kind, rays, block, answered, options, keep_alone);
    return stats;
  };
  return trace_blocks(snapshot, kind, rays, kRaysPerBlock, options, answer);
}

NoPencils no_pencils(EpochPin&, const instances::OpenTrees&) { return {}; }

/// Appends the hits of the rays of a block, in order.
TraceStats list_block(const instances::OpenTrees& trees, const RayColumns& rays,
                      const RayBlock& block, std::span<RayTally> tallies, std::vector<Hit>& hits,
                      const TraceOptions& options) {
  EpochPin pin;
  PacketCaster caster(pin, trees, QueryKind::kAll, options);
  std::optional<RayCaster> alone;
  for (std::size_t first = block.first; first < block.end; first += kLanes) {
    if (is_cancelled(options.cancelled)) break;
    const std::size_t end = std::min(first + kLanes, block.end);
    const std::uint32_t answered = caster.cast(rays, {first, end - first});
    for (std::size_t i = first; i < end; ++i) {
      if ((answered >> (i - first) & 1) != 0) {
        tallies[i] = caster.list(i - first, hits);
        continue;
      }
      if (is_cancelled(options.cancelled)) continue;
      if (!alone) alone.emplace(pin, trees, options);
      const Ray ray = rays[i];
      if (cast_ray(*alone, QueryKind::kAll, ray, WhenPending::kWait))
        tallies[i] = alone->list(hits);
    }
  }
  TraceStats stats = caster.stats();
  if (alone) stats += alone->stats();
  return stats;
}

/// The stats of a batch, with the rays that have no answer.
Result<TraceStats> with_unanswered(Result<TraceStats> traced, std::size_t rays,
                                   const TraceOptions& options) {
  if (traced && options.partial && is_cancelled(options.cancelled))
    traced->unanswered = rays - traced->rays;
  return traced;
}

void mark_unanswered(const HitColumns& hits) {
  Hit unanswered;
  unanswered.t = -accel::geometry::kInfinity;
  unanswered.state = accel::geometry::HitState::kUnanswered;
  for (std::size_t i = 0; i < hits.size; ++i) hits.set(i, unanswered);
}

void mark_unanswered(std::span<RayTally> tallies, std::uint32_t count) {
  std::fill(tallies.begin(), tallies.end(),
            RayTally{.count = count, .state = accel::geometry::HitState::kUnanswered});
}

Status check_sizes(std::size_t rays, std::size_t answers) {
  if (rays == answers) return {};
  return Error{Code::kInvalidArgument,
               std::to_string(rays) + " rays but room for " + std::to_string(answers) + " answers",
               "COUNT_MISMATCH"};
}

}  // namespace

Result<TraceStats> trace(const revision::Snapshot& snapshot, const RayColumns& rays,
                         const HitColumns& hits, const TraceOptions& given_options) {
  TraceOptions options = given_options;
  options.surface &= hits.has_surface();
  if (const Status good = check_sizes(rays.size, hits.size); !good) return good.error();
  if (options.kind != QueryKind::kClosest && options.kind != QueryKind::kAny)
    return Error{Code::kInvalidArgument, "trace() answers closest and any", "UNKNOWN_KIND"};
  // Rays that are answered alone set only their own bits.
  if (hits.bits != nullptr) std::fill_n(hits.bits, (hits.size + 7) / 8, std::uint8_t{0});
  if (options.partial) mark_unanswered(hits);
  auto traced = cast_rays(
      snapshot, options.kind, rays, options,
      [&](EpochPin& pin, const instances::OpenTrees& trees) {
        return HitPencils(pin, trees, options, rays, hits);
      },
      [&](std::size_t, std::uint32_t answered, PacketCaster& caster) {
        if (answered != 0) caster.write(hits);
      },
      [&](std::size_t i, const RayCaster& caster) { hits.set(i, caster.hit()); });
  return with_unanswered(std::move(traced), rays.size, options);
}

Result<TraceStats> trace(const revision::Snapshot& snapshot, std::span<const Ray> rays,
                         std::span<Hit> hits, const TraceOptions& options) {
  return trace(snapshot, columns_of(rays), columns_of(hits), options);
}

Result<TraceStats> count_hits(const revision::Snapshot& snapshot, const RayColumns& rays,
                              std::span<RayTally> tallies, const TraceOptions& options) {
  if (const Status good = check_sizes(rays.size, tallies.size()); !good) return good.error();
  if (options.partial) mark_unanswered(tallies, kUnansweredCount);
  auto traced = cast_rays(
      snapshot, QueryKind::kCount, rays, options, no_pencils,
      [&](std::size_t first, std::uint32_t answered, PacketCaster& caster) {
        for (; answered != 0; answered &= answered - 1) {
          const auto lane = static_cast<std::size_t>(std::countr_zero(answered));
          tallies[first + lane] = caster.count(lane);
        }
      },
      [&](std::size_t i, RayCaster& caster) { tallies[i] = caster.count(); });
  return with_unanswered(std::move(traced), rays.size, options);
}

Result<TraceStats> count_hits(const revision::Snapshot& snapshot, std::span<const Ray> rays,
                              std::span<RayTally> tallies, const TraceOptions& options) {
  return count_hits(snapshot, columns_of(rays), tallies, options);
}

Result<TraceStats> list_hits(const revision::Snapshot& snapshot, std::span<const Ray> rays,
                             std::span<RayTally> tallies, std::vector<Hit>& hits,
                             const TraceOptions& options) {
  if (const Status good = check_sizes(rays.size(), tallies.size()); !good) return good.error();
  const std::size_t rays_per_block = std::clamp<std::size_t>(
      options.hits_per_block / std::max(options.max_hits, 1u), 1, kRaysPerListBlock);
  std::vector<std::vector<Hit>> of_blocks((rays.size() + rays_per_block - 1) / rays_per_block);
  // Blocks are taken in order, so that the answered rays are always the first ones.
  std::atomic<std::size_t> next{0}, listed{0};
  const RayColumns columns = columns_of(rays);
  if (options.partial) mark_unanswered(tallies, 0);
  const auto answer = [&](const instances::OpenTrees& trees, const RayBlock&) -> TraceStats {
    if (listed.load(std::memory_order_relaxed) >= options.hits_at_once) return {};
    const std::size_t block = next.fetch_add(1, std::memory_order_relaxed);
    const std::size_t first = block * rays_per_block;
    const RayBlock part{first, std::min(first + rays_per_block, rays.size())};
    const TraceStats stats = list_block(trees, columns, part, tallies, of_blocks[block], options);
    listed.fetch_add(of_blocks[block].size(), std::memory_order_relaxed);
    return stats;
  };
  Result<TraceStats> traced =
      trace_blocks(snapshot, QueryKind::kCount, columns, rays_per_block, options, answer);
  if (!traced) return traced;
  hits.clear();
  hits.reserve(traced->hits_found);
  for (std::vector<Hit>& block : of_blocks) {
    hits.insert(hits.end(), block.begin(), block.end());
    block = {};
  }
  return with_unanswered(std::move(traced), rays.size(), options);
}

Status grow_for_rays(const revision::Snapshot& snapshot, std::span<const Ray> rays,
                     const TraceOptions& options, query::BuildProgress& progress) {
  // Lists grow what counts grow.
  const QueryKind kind = options.kind == QueryKind::kAll ? QueryKind::kCount : options.kind;
  constexpr std::size_t kRaysPerReport = 4096;
  while (!rays.empty()) {
    const auto part = rays.first(std::min(rays.size(), kRaysPerReport));
    rays = rays.subspan(part.size());
    const auto cast = cast_rays(
        snapshot, kind, columns_of(part), options, no_pencils,
        [](std::size_t, std::uint32_t, PacketCaster&) {}, [](std::size_t, RayCaster&) {});
    if (!cast) return cast.error();
    progress.add(cast->cells_expanded, cast->build_seconds);
    progress.rays_done += part.size();
  }
  return {};
}

}  // namespace sightline::scenegraph
