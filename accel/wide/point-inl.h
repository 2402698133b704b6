// Takes one point at a time through a tree: to the nearest of eight boxes first, then to all
// triangles of a block at once.
#if defined(SIGHTLINE_WIDE_POINT_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef SIGHTLINE_WIDE_POINT_INL
#undef SIGHTLINE_WIDE_POINT_INL
#else
#define SIGHTLINE_WIDE_POINT_INL
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <hwy/cache_control.h>

#include "accel/blocks/block.h"
#include "accel/wide/distance-inl.h"
#include "accel/wide/exact.h"
#include "accel/wide/float_points.h"
#include "accel/wide/gather-inl.h"
#include "accel/wide/walk-inl.h"
#include "accel/wide/walk.h"

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

/// What walk_tree() takes through a tree. The t of entries is the square of the distance from which
/// their box is certainly not nearer.
template <Goal kGoal>
class Point {
 public:
  HWY_INLINE Point(const Walked& walked, std::size_t lane)
      : walked_(walked), packet_(walked.packet), lane_(lane) {
    const FloatPoints& near = packet_.near;
    geometry::Vec3f off;
    for (std::size_t axis = 0; axis < 3; ++axis) off[axis] = near.box_off[axis][lane];
    off = stretched_off(near, off);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      at_[axis] = Boxes::set(near.box_at[axis][lane]);
      off_[axis] = Boxes::set(off[axis]);
    }
  }

  struct Entry {
    float t;
    Child at;
  };

  /// Takes over the limit of a point of the same tree which sees the same faces: the nearest one's
  /// distance differs by no more than the points do.
  void limit_by(std::size_t other) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double way = packet_.rays.origin[axis][lane_] - packet_.rays.origin[axis][other];
      squared += way * way;
    }
    const double way = std::sqrt(squared) * packet_.scale * (1 + 0x1p-40);
    if (!(way < 0x1p+60)) return;
    const FloatPoints& near = packet_.near;
    const float more = geometry::round_up(way) * near.spread + near.slack[lane_] + near.off[lane_];
    lower((packet_.floats.high[other] + more) * (1 + 0x1p-21f));
  }

  /// Limits the point by its distance from a vertex that it sees, as landmark() returns it.
  void limit_by(const geometry::Vec3f& vertex) {
    const FloatPoints& near = packet_.near;
    const geometry::Vec3f way = seen_from(stretched(near, vertex));
    const float length = std::sqrt(dot(way, way)) * (1 + 0x1p-20f) + near.off[lane_];
    if (0x1p-40f < length && length < 0x1p+60f) lower_by(length);
  }
  /// A vertex of the block that has lowered the limit last; infinite if none has.
  const geometry::Vec3f& landmark() const { return landmark_; }
  static constexpr geometry::Vec3f nowhere() {
    return {std::numeric_limits<float>::infinity(), 0, 0};
  }

  void walk(Child root) {
    walk_tree(*this, {0, root});
    walked_.counters.steps += nodes_;
    walked_.counters.tests += triangles_;
    packet_.work[lane_] += static_cast<std::uint32_t>(nodes_ + triangles_);
  }

  HWY_INLINE bool visit_node(Entry& entry, Stack<Entry>& stack) {
    ++nodes_;
    const kdtree::WideNode& node = *entry.at.node();
    const std::array<Boxes, 3> gap = packet_.near.stretched ? stretched_gaps(node) : gaps(node);
    const auto squared_gap = [&](std::size_t axis) {
      const Boxes beyond = max(gap[axis] - off_[axis], Boxes::set(0));
      return beyond * beyond;
    };
    const Boxes squared =
        (squared_gap(0) + squared_gap(1) + squared_gap(2)) * Boxes::set(1 - 0x1p-20f);
    std::uint32_t met = squared <= Boxes::set(packet_.near.limit_squared[lane_]);
    // The stretched gaps of a child that does not exist are not numbers.
    if (packet_.near.stretched)
      met &= Boxes::load(node.bounds[0].data()) <= Boxes::load(node.bounds[1].data());
    if (met == 0) return false;
    const auto first = static_cast<std::size_t>(std::countr_zero(met));
    prefetch(node, met);
    met &= met - 1;
    const Child parent = entry.at;
    alignas(64) std::array<float, kdtree::kWidth> t;
    squared.store(t.data());
    entry = {t[first], parent.child(first)};
    if (met != 0) push_others<true>(parent, t, met, entry, stack);
    return true;
  }

  /// A cell that is not built, and a list, wait until nothing else is nearer: so no cell is
  /// expanded that is farther than the answer.
  HWY_INLINE bool enter(Entry& entry) {
    if (entry.at.is_list() || kdtree::load(entry.at.slot()).is_deferred()) {
      later_.push_back(entry);
      std::push_heap(later_.begin(), later_.end(), is_farther);
      return false;
    }
    entry.at = wide::enter(entry.at, 1u << lane_, walked_.leaf);
    return static_cast<bool>(entry.at);
  }

  HWY_INLINE bool next(Entry& entry, Stack<Entry>& stack) {
    if (!later_.empty() && !matters(later_.front())) later_.clear();
    while (later_.empty()) {
      if (stack.empty()) return false;
      entry = stack.pop();
      if (matters(entry)) return true;
    }
    return next_or_later(entry, stack);
  }

  static constexpr bool part(const Entry&) { return false; }
  HWY_INLINE bool is_done() const {
    return packet_.stopped || (kGoal == Goal::kAny && (packet_.best->found >> lane_ & 1) != 0);
  }
  HWY_INLINE bool matters(const Entry& entry) const {
    return entry.t <= packet_.near.limit_squared[lane_];
  }

  void visit_block(const Entry& entry) {
    const std::uint32_t* const words = entry.at.block();
    const blocks::Block block(words);
    triangles_ += block.triangles;
    // A point in the middle of a sphere visits all of it.
    constexpr std::uint32_t kBlocksPerLook = 64;
    if (++blocks_ % kBlocksPerLook == 0 && packet_.cancelled != nullptr &&
        packet_.cancelled->load(std::memory_order_relaxed))
      packet_.stopped = true;
    const FloatPoints& near = packet_.near;
    const Floats unit = Floats::set(near.unit[lane_]);
    const auto column = [&](std::size_t axis) {
      return Floats::load_unaligned(block.x + axis * block.vertices);
    };
    const Vectors16 at = measure({column(0), column(1), column(2)});
    const auto relative = [&](const Floats& x, std::size_t axis) {
      return ((x - Floats::set(near.high[axis][lane_])) - Floats::set(near.low[axis][lane_])) *
             unit;
    };
    const Vectors16 seen{relative(at.x, 0), relative(at.y, 1), relative(at.z, 2)};
    const Floats squared = dot(seen, seen);
    const std::uint32_t vertices = (2u << (block.vertices - 1)) - 1;
    const std::size_t nearest = least_of(vertices, squared);
    const float before = packet_.floats.high[lane_];
    const Way way = way_to(block, nearest, seen, squared);
    if (is_beyond(way, vertices)) return;
    const std::uint32_t visible = visible_faces(block);
    if (visible == 0) return;
    // A vertex may limit the point if it is one of a face that it sees.
    const bool sees_all = visible == faces_of(block);
    if (!sees_all || !remember_corner(words, way, squared))
      visit_triangles(words, seen, squared, visible);
    if (sees_all && packet_.floats.high[lane_] < before) landmark_ = block.vertex(nearest);
  }

 private:
  static bool is_farther(const Entry& a, const Entry& b) { return a.t > b.t; }

  /// Goes on to the nearest of all that waits, and enters it if it is not built.
  bool next_or_later(Entry& entry, Stack<Entry>& stack) {
    while (!is_done()) {
      if (!stack.empty()) stack.raise_nearest();
      const bool is_built = !stack.empty() && (later_.empty() || stack.top().t < later_.front().t);
      if (!is_built && later_.empty()) return false;
      if (is_built) {
        entry = stack.pop();
        return matters(entry);  // if not, nothing does
      }
      std::pop_heap(later_.begin(), later_.end(), is_farther);
      entry = later_.back();
      later_.pop_back();
      if (!matters(entry)) return false;
      entry.at = wide::enter(entry.at, 1u << lane_, walked_.leaf);
      if (entry.at) return true;
    }
    return false;
  }

  /// How far the boxes of the children are from the point on each axis.
  HWY_INLINE std::array<Boxes, 3> gaps(const kdtree::WideNode& node) const {
    const auto gap = [&](std::size_t axis) {
      const Boxes lo = Boxes::load(node.bounds[2 * axis].data()),
                  hi = Boxes::load(node.bounds[2 * axis + 1].data());
      return max(lo - at_[axis], at_[axis] - hi);
    };
    return {gap(0), gap(1), gap(2)};
  }

  /// How far the boxes around their stretched selves are.
  HWY_INLINE std::array<Boxes, 3> stretched_gaps(const kdtree::WideNode& node) const {
    std::array<Boxes, 3> center, half;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Boxes lo = Boxes::load(node.bounds[2 * axis].data()) - at_[axis],
                  hi = Boxes::load(node.bounds[2 * axis + 1].data()) - at_[axis];
      center[axis] = (lo + hi) * Boxes::set(0.5f);
      half[axis] = (hi - lo) * Boxes::set(0.5f);
      // What roundings lose on the way.
      half[axis] = mul_add(abs(center[axis]) + half[axis], Boxes::set(0x1p-20f), half[axis]);
    }
    const auto gap = [&](std::size_t row, std::size_t first) {
      Boxes middle = Boxes::set(0), reach = Boxes::set(0);
      for (std::size_t axis = row; axis < 3; ++axis) {
        const float r = packet_.near.metric[first + axis - row];
        middle = mul_add(Boxes::set(r), center[axis], middle);
        reach = mul_add(Boxes::set(std::fabs(r)), half[axis], reach);
      }
      return abs(middle) - reach;
    };
    return {gap(0, 0), gap(1, 3), gap(2, 5)};
  }

  /// A vertex, as stretched() gives it, relative to the point.
  HWY_INLINE geometry::Vec3f seen_from(const geometry::Vec3f& vertex) const {
    const auto relative = [&](float x, std::size_t axis) {
      return (x - packet_.near.high[axis][lane_]) - packet_.near.low[axis][lane_];
    };
    return {relative(vertex.x, 0), relative(vertex.y, 1), relative(vertex.z, 2)};
  }

  HWY_INLINE Vectors16 measure(const Vectors16& v) const {
    if (!packet_.near.stretched) return v;
    const auto r = [this](std::size_t i) { return Floats::set(packet_.near.metric[i]); };
    return {mul_add(r(0), v.x, mul_add(r(1), v.y, r(2) * v.z)), mul_add(r(3), v.y, r(4) * v.z),
            r(5) * v.z};
  }

  static HWY_INLINE std::uint32_t faces_of(const blocks::Block& block) {
    return (2u << (block.triangles - 1)) - 1;
  }

  /// The faces of a block that the point sees. Most blocks have faces of one mesh.
  HWY_INLINE std::uint32_t visible_faces(const blocks::Block& block) const {
    const std::uint32_t all = faces_of(block);
    const Visibility* const visible = packet_.placed.visible;
    if (visible == nullptr) return all;
    std::uint32_t faces = 0, sees = 0;
    const PlacedMesh* mesh = nullptr;
    for (std::uint32_t i = 0; i < block.triangles; ++i) {
      const PlacedMesh& of = packet_.placed.of(block.id(i));
      if (&of != mesh) sees = visible->seeing(visible->asked, of, 1u << lane_) >> lane_;
      mesh = &of;
      faces |= sees << i;
    }
    return faces;
  }

  /// Tests these triangles of a block whose vertices are seen so, relative to the point and in its
  /// units.
  HWY_INLINE void visit_triangles(const std::uint32_t* words, const Vectors16& seen,
                                  const Floats& squared, std::uint32_t visible) {
    const blocks::Block block(words);
    const FloatPoints& near = packet_.near;
    const Floats unit = Floats::set(near.unit[lane_]), per_unit = Floats::set(near.per_unit[lane_]);
    const auto column = [&](std::size_t axis) {
      return Floats::load_unaligned(block.x + axis * block.vertices) * unit;
    };
    const std::uint32_t vertices = (2u << (block.vertices - 1)) - 1;
    const float size = std::sqrt(Floats::pick(vertices, squared, Floats::set(0)).greatest());
    std::array<GatheredAxis, 3> axes;
    axes[0].set(column(0), seen.x);
    axes[1].set(column(1), seen.y);
    axes[2].set(column(2), seen.z);
    std::array<Vectors16, 3> at;
    std::array<Vectors16, 2> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const Gather of(block.corner(k));
      at[k] = {axes[0].vertices(of), axes[1].vertices(of), axes[2].vertices(of)};
      if (k < 2) corners[k] = {axes[0].corners(of), axes[1].corners(of), axes[2].corners(of)};
    }
    const float most = size * (1 + 0x1p-10f) + 0x1p-60f;
    Distances found = distances({corners[0], corners[1], measure(at[1] - at[0]),
                                 measure(at[2] - at[0]), measure(at[2] - at[1])},
                                Floats::set(most * near.share), Floats::set(near.share),
                                Floats::set(near.off[lane_] * near.unit[lane_] + 0x1p-59f));
    found.low = found.low * per_unit;
    found.high = found.high * per_unit;
    // The negation also includes a distance that is NaN, of which floats know nothing.
    const std::uint32_t open = visible & ~(found.low > Floats::set(packet_.floats.high[lane_]));
    if (open != 0) take(words, found, open);
  }

  /// The numbers of the vertices of a block on one axis, as they are and relative to the point.
  class GatheredAxis {
   public:
    HWY_INLINE void set(const Floats& vertices, const Floats& relative) {
      vertices_ = vertices;
      relative_ = relative;
      if constexpr (Floats::kVectors > 1) {
        vertices.store(stored_[0].data());
        relative.store(stored_[1].data());
      }
    }
    HWY_INLINE Floats vertices(const Gather& of) const { return of(vertices_, stored_[0].data()); }
    HWY_INLINE Floats corners(const Gather& of) const { return of(relative_, stored_[1].data()); }

   private:
    Floats vertices_, relative_;
    alignas(64) std::array<std::array<float, 16>, 2> stored_;
  };

  /// The index of the least of these numbers.
  static HWY_INLINE std::size_t least_of(std::uint32_t lanes, const Floats& x) {
    const float least =
        Floats::pick(lanes, x, Floats::set(std::numeric_limits<float>::infinity())).least();
    const std::uint32_t equals = equal(x, Floats::set(least)) & lanes;
    return static_cast<std::size_t>(std::countr_zero(equals == 0 ? 1u : equals));
  }

  /// The way from the point to a vertex of a block.
  struct Way {
    Floats along;             ///< How far the block's vertices are along the way, times its length.
    float squared = 0;        ///< Its length, squared.
    std::uint32_t ahead = 0;  ///< The vertices that are certainly less than 76 degrees aside.
  };

  HWY_INLINE Way way_to(const blocks::Block& block, std::size_t vertex, const Vectors16& seen,
                        const Floats& squared) const {
    const FloatPoints& near = packet_.near;
    const geometry::Vec3f g = seen_from(stretched(near, block.vertex(vertex))) * near.unit[lane_];
    const Floats along = mul_add(seen.x, Floats::set(g.x),
                                 mul_add(seen.y, Floats::set(g.y), seen.z * Floats::set(g.z)));
    const float length = dot(g, g);
    const Floats aside =
        mul_add(squared, Floats::set(length * (0x1p-4f * (1 + 0x1p-17f))), Floats::set(0x1p-100f));
    return {along, length, (along > Floats::set(0)) & (along * along > aside)};
  }

  /// Whether these vertices, and so the faces between them, certainly lie beyond the limit: behind
  /// a plane across the way.
  HWY_INLINE bool is_beyond(const Way& way, std::uint32_t vertices) const {
    const FloatPoints& near = packet_.near;
    const float limit = (packet_.floats.high[lane_] + near.off[lane_]) * near.unit[lane_];
    const std::uint32_t beyond =
        way.along * way.along > Floats::set(limit * limit * (way.squared * (1 + 0x1p-17f)));
    return (beyond & way.ahead & vertices) == vertices;
  }

  /// Where a block is so far away that it is seen within a narrow cone around the way: its faces
  /// are hardly nearer than planes across the way, so that these leave those around the nearest
  /// vertex. Remembers them, unless they are many.
  HWY_INLINE bool remember_corner(const std::uint32_t* words, const Way& way,
                                  const Floats& squared) {
    if (kGoal != Goal::kNearest) return false;
    const blocks::Block block(words);
    const std::uint32_t vertices = (2u << (block.vertices - 1)) - 1;
    const std::uint32_t in_cone =
        way.along * way.along > squared * Floats::set(way.squared * (1 - kCone));
    if ((in_cone & way.ahead & vertices) != vertices || !(way.squared > 0x1p-90f)) return false;
    const FloatPoints& near = packet_.near;
    const float per_unit = near.per_unit[lane_], off = near.off[lane_];
    const float length = std::sqrt(way.squared);
    lower_by(length * per_unit * (1 + 0x1p-20f) + off);
    alignas(64) std::array<float, 16> stored;
    if constexpr (Floats::kVectors > 1) way.along.store(stored.data());
    const auto corner = [&](std::size_t k) {
      return Gather(block.corner(k))(way.along, stored.data());
    };
    const Floats low = min(corner(0), min(corner(1), corner(2))) *
                           Floats::set(per_unit / length * (1 - 0x1p-18f)) -
                       Floats::set(off);
    std::uint32_t open = faces_of(block) & ~(low > Floats::set(packet_.floats.high[lane_]));
    if (std::popcount(open) > kFew) return false;
    low.store(stored.data());
    for (; open != 0; open &= open - 1) {
      const auto i = static_cast<std::uint32_t>(std::countr_zero(open));
      remember(packet_, lane_, words, i, stored[i]);
    }
    return true;
  }
  /// The square of the sine of the cone's angle, and the most faces: docs/decisions/points.md has
  /// what others cost.
  static constexpr float kCone = 0x1p-6f;
  static constexpr int kFew = 6;

  /// Fetches these children, of which the nearest is visited at once, and most others soon.
  static HWY_INLINE void prefetch(const kdtree::WideNode& node, std::uint32_t children) {
    constexpr std::uint64_t kLine = 64, kLines = 4;  // A node, and most blocks
    for (; children != 0; children &= children - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(children));
      const std::uint64_t address = kdtree::load(node.children[i]).bits() & ~(kLine - 1);
      for (std::uint64_t line = 0; line < kLines; ++line)
        hwy::Prefetch(std::bit_cast<const char*>(address + line * kLine));
    }
  }

  /// Takes the faces of `open`, which may be near enough.
  void take(const std::uint32_t* words, const Distances& found, std::uint32_t open) {
    if constexpr (kGoal == Goal::kNearest) {
      const float nearest =
          Floats::pick(open, found.high, Floats::set(std::numeric_limits<float>::max())).least();
      lower_by(nearest);
      alignas(64) std::array<float, 16> low;
      found.low.store(low.data());
      for (; open != 0; open &= open - 1) {
        const auto i = static_cast<std::uint32_t>(std::countr_zero(open));
        if (!(low[i] > packet_.floats.high[lane_])) remember(packet_, lane_, words, i, low[i]);
      }
    } else {
      const std::uint32_t certain = open & (found.high <= Floats::set(packet_.near.sure[lane_]));
      if constexpr (kGoal == Goal::kAny) {
        if (certain != 0) packet_.best->found |= 1u << lane_;
      } else if (packet_.sinks[lane_].primitives != nullptr) {
        open &= ~certain;
        for (std::uint32_t left = certain; left != 0; left &= left - 1)
          add_certain(packet_, lane_, words, static_cast<std::uint32_t>(std::countr_zero(left)));
      }
      for (; open != 0 && !is_done(); open &= open - 1)
        decide(packet_, lane_, words, static_cast<std::uint32_t>(std::countr_zero(open)));
    }
  }

  /// Lowers the limit, as there is a face at this distance in the frame, or before.
  HWY_INLINE void lower_by(float nearest) {
    const FloatPoints& near = packet_.near;
    lower(nearest * near.spread * (1 + 0x1p-22f) + near.slack[lane_] * (1 + 0x1p-22f));
  }

  /// Lowers the limit to this.
  void lower(float high) {
    if (!(high < packet_.floats.high[lane_])) return;
    packet_.floats.high[lane_] = high;
    packet_.near.limit_squared[lane_] =
        std::min(high * high * (1 + 0x1p-21f), std::numeric_limits<float>::max());
  }

  const Walked& walked_;
  Packet& packet_;
  const std::size_t lane_;
  std::array<Boxes, 3> at_, off_;
  std::uint64_t nodes_ = 0, triangles_ = 0;
  std::uint32_t blocks_ = 0;
  std::vector<Entry> later_;  // a heap, the nearest on top
  geometry::Vec3f landmark_ = nowhere();
};

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#endif  // toggle
