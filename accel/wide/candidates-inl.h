// What a packet remembers of the verdicts on one triangle: hits, and candidates for the exact rule.
#if defined(SIGHTLINE_WIDE_CANDIDATES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_CANDIDATES_INL
#undef SIGHTLINE_WIDE_CANDIDATES_INL
#else
#define SIGHTLINE_WIDE_CANDIDATES_INL
#endif

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "accel/blocks/block.h"
#include "accel/wide/exact.h"
#include "accel/wide/verdict-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

/// The rays that certainly have a hit, at these depths, within their limits.
HWY_INLINE std::uint32_t certain(const Packet& packet, const Verdict& verdict, const Floats& low,
                                 const Floats& high) {
  const FloatRays& rays = packet.floats;
  return verdict.certain & (low >= Floats::load(rays.sure_low.data())) &
         (high <= Floats::load(rays.sure_high.data()));
}

/// Finds the rays that hit this triangle, for Goal::kAny.
HWY_INLINE void find(Packet& packet, const std::uint32_t* words, std::uint32_t triangle,
                     const Verdict& verdict) {
  const std::uint32_t found =
      certain(packet, verdict, verdict.depth - verdict.off, verdict.depth + verdict.off);
  packet.best->found |= found;
  for (std::uint32_t left = verdict.possible & ~found; left != 0; left &= left - 1)
    decide(packet, static_cast<std::size_t>(std::countr_zero(left)), words, triangle);
}

/// Offers the hits of this triangle, for Goal::kEvery. Where hits are only counted, a certain hit
/// is counted without its t. Returns whether the limits of some ray were tightened.
HWY_INLINE bool offer_every(Packet& packet, const std::uint32_t* words, std::uint32_t triangle,
                            const Verdict& verdict) {
  std::uint32_t counted = 0;
  if (packet.sinks[0].primitives != nullptr)
    counted = certain(packet, verdict, verdict.depth - verdict.off, verdict.depth + verdict.off);
  for (std::uint32_t left = counted; left != 0; left &= left - 1)
    add_certain(packet, static_cast<std::size_t>(std::countr_zero(left)), words, triangle);
  return decide_lanes(packet, verdict.possible & ~counted, words, triangle);
}

/// Adds pairs that may be nearest hits. Returns whether some ray has a nearer certain hit now.
HWY_INLINE bool add_candidates(Packet& packet, const std::uint32_t* words, std::uint32_t triangle,
                               const Verdict& verdict) {
  FloatRays& rays = packet.floats;
  Candidates& all = packet.candidates;
  const Floats low = verdict.depth - verdict.off, high = verdict.depth + verdict.off,
               slack = Floats::load(rays.slack.data()), before = Floats::load(rays.high.data());
  const std::uint32_t nearer = certain(packet, verdict, low, high) & (high + slack < before);
  const Floats limit = Floats::pick(nearer, high + slack, before), least = low - slack;
  limit.store(rays.high.data());
  using Numbers = Lanes<std::uint32_t, kLanes>;
  const Numbers id = Numbers::set(blocks::Block(words).id(triangle)),
                best_id = Numbers::load(all.best_id.data());
  // A triangle that lies in several blocks may be the best already.
  const std::uint32_t others = ~(all.has_best & equal(best_id, id));
  // These rays' former best may still be the nearest; this triangle is open for rays for which it
  // is neither certain nor too far.
  std::uint32_t best_before =
      nearer & all.has_best & others & (Floats::load(all.best_low.data()) <= limit);
  // "Not above" also includes a depth that is NaN, of which floats know nothing.
  std::uint32_t open = verdict.possible & ~nearer & others & ~(least > limit);
  for (; best_before != 0; best_before &= best_before - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(best_before));
    remember(packet, lane, all.best_block[lane], all.best_triangle[lane], all.best_low[lane]);
  }
  if (open != 0) {
    alignas(64) std::array<float, kLanes> depth;
    least.store(depth.data());
    for (; open != 0; open &= open - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(open));
      remember(packet, lane, words, triangle, depth[lane]);
    }
  }
  if (nearer == 0) return false;
  all.has_best |= nearer;
  Numbers::pick(nearer, id, best_id).store(all.best_id.data());
  Numbers::pick(nearer, Numbers::set(triangle), Numbers::load(all.best_triangle.data()))
      .store(all.best_triangle.data());
  Floats::pick(nearer, least, Floats::load(all.best_low.data())).store(all.best_low.data());
  for (std::uint32_t left = nearer; left != 0; left &= left - 1)
    all.best_block[static_cast<std::size_t>(std::countr_zero(left))] = words;
  return true;
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle
