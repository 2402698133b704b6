#include "scenegraph/query/frustum_caster.h"

#include <algorithm>
#include <bit>

#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/wide/transform.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::HitColumns;
using accel::geometry::RayColumns;
using accel::wide::kLanes;
using accel::wide::Packet;

/// The instance of a revision that has only one, if rays see it; else null.
const instances::Instance* find_only(const instances::OpenTrees& trees,
                                     const TraceOptions& options) {
  if (trees.size() != 1) return nullptr;
  const instances::OpenTree& holder = *std::ranges::find_if(
      trees.all(), [](const auto& tree) { return tree.instances.size() == 1; });
  const instances::Instances& tree = holder.instances;
  if (!tree.tree().only()) return nullptr;
  return is_seen(holder, 0, options.selection) ? &tree[0] : nullptr;
}

/// Asks for memory that is read later, or written. It is always inline, as GCC drops calls of
/// functions that only prefetch.
template <bool kWritten>
[[gnu::always_inline]] inline void prefetch(const std::byte* begin, const std::byte* end) {
  constexpr std::ptrdiff_t kLine = 64;
  for (; begin < end; begin += kLine) __builtin_prefetch(begin, kWritten);
}

}  // namespace

FrustumCaster::FrustumCaster(accel::kdtree::EpochPin& pin, const instances::OpenTrees& trees,
                             const TraceOptions& options, const RayColumns& rays,
                             const HitColumns& hits)
    : pin_(pin),
      trees_(trees),
      options_(options),
      rays_(rays),
      hits_(hits),
      only_(find_only(trees, options)),
      any_(options.kind == QueryKind::kAny) {}

void FrustumCaster::make_group() {
  group_ = std::make_unique<Group>();
  for (std::size_t p = 0; p < group_->packets.size(); ++p) {
    Packet& packet = group_->packets[p];
    packet.best = &group_->best[p];
    packet.goal = any_ ? accel::wide::Goal::kAny : accel::wide::Goal::kNearest;
    packet.node = only_->node;
    packet.instance = 0;
    packet.culling = options_.culling;
  }
}

bool FrustumCaster::answers(const RayPacket& packet, std::size_t end) {
  const std::size_t first = packet.first, next = std::min(first + kFrustumRays, end);
  answered_ >>= 1;
  if (first % kFrustumRays == 0) {
    // These are the columns that structs begin with; the processor prefetches narrower ones by
    // itself.
    const std::size_t last = std::min(next + kFrustumRays, rays_.size);
    prefetch<false>(rays_.origin[0].at(next), rays_.origin[0].at(last));
    if (hits_.t.is_asked()) prefetch<true>(hits_.t.at(next), hits_.t.at(last));
    answered_ = cast(first, next - first);
  }
  return (answered_ & 1) != 0;
}

std::uint32_t FrustumCaster::cast(std::size_t first, std::size_t count) {
  // One ray is no frustum.
  if (only_ == nullptr || count == 1 || !only_->mesh->is_resident()) return 0;
  if (to_skip_ > 0) {
    --to_skip_;
    return 0;
  }
  if (!group_) make_group();
  pin_.renew();
  const std::size_t packets = (count + kLanes - 1) / kLanes;
  const Lanes lanes = read(first, count);
  accel::kdtree::WalkCounters walked;
  const Lanes done = only_->mesh->owned_tree().tree.query_frustum(
      std::span(group_->packets).first(packets), lanes, walked);
  const std::uint32_t answered = write(first, count, done);
  to_skip_ = failed_;
  failed_ = answered == 0 ? 2 * failed_ + 2 : 0;
  if (answered == 0) return 0;
  stats_.traversal_steps += walked.steps;
  stats_.triangle_tests += walked.tests;
  if (options_.growth != Growth::kBuiltOnly) only_->mark_entered();
  return answered;
}

/// Returns the rays in the instance's frame that are valid and see it.
FrustumCaster::Lanes FrustumCaster::read(std::size_t first, std::size_t count) {
  Lanes lanes{};
  for (std::size_t i = 0, p = 0; i < count; i += kLanes, ++p) {
    const RayPacket range{first + i, std::min(kLanes, count - i)};
    accel::wide::GivenRays& given = group_->given[p];
    Packet& packet = group_->packets[p];
    accel::wide::read(rays_, range.first, range.count, given);
    packet.work.fill(0);
    group_->best[p].clear();
    group_->masks.read(rays_.mask, range);
    const std::uint32_t valid = accel::wide::valid(given, trees_.static_tree().center(),
                                                   group_->masks.seeing(only_->mask, range.lanes));
    lanes[p] = accel::wide::transform(given, only_->local_from_world.m, valid, packet.rays);
  }
  return lanes;
}

std::uint32_t FrustumCaster::write(std::size_t first, std::size_t count, const Lanes& done) {
  std::uint32_t answered = 0;
  for (std::size_t i = 0, p = 0; i < count; i += kLanes, ++p) {
    const RayPacket range{first + i, std::min(kLanes, count - i)};
    const std::uint32_t lanes = done[p];
    if (lanes != range.lanes) continue;
    answered |= 1u << p;
    const accel::wide::Outcome outcome{
        group_->best[p], group_->packets[p].work, lanes, lanes, 0, any_};
    accel::wide::write(outcome, hits_, range.first);
    if (options_.surface && !any_)
      write_surfaces({group_->given[p], outcome, range.first, true}, trees_, rays_, hits_);
    stats_.rays += range.count;
    stats_.hits += static_cast<std::uint64_t>(std::popcount(group_->best[p].found));
    stats_.instances_entered += range.count;
  }
  return answered;
}

}  // namespace sightline::scenegraph::query
