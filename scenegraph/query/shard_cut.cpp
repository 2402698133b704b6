// Cuts scenes into shards, and finds the shards of rays.
#include "scenegraph/query/shard_cut.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "scenegraph/instances/instance_bounds.h"
#include "scenegraph/query/morton.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Aabb;
using accel::geometry::Vec3d;

/// Bits of a Morton code for each axis.
constexpr unsigned kAxisBits = 21;
/// This number changes with the rules of the cut, as servers that cut in other ways must not agree.
constexpr std::uint64_t kRules = 2;

struct Placed {
  std::uint64_t code;
  const model::Node* node;
  Aabb box;  // relative to the centre of the cut
};

/// The centre of the instance's box in the world; not finite if the box is not.
Vec3d center_of(const model::Affine& world_from_local, const model::Node& node) {
  const model::DoubleBox box = mapped(world_from_local, model::DoubleBox(node.mesh->bounds()));
  return box.lo * 0.5 + box.hi * 0.5;
}

/// Cells of a cube that holds the box.
class Grid {
 public:
  explicit Grid(const model::DoubleBox& box) : lo_(box.lo) {
    const Vec3d extent = box.hi - box.lo;
    extent_ = std::max({extent.x, extent.y, extent.z});
  }

  std::uint64_t code(const Vec3d& point) const {
    return spread_bits(cell(point.x - lo_.x)) | spread_bits(cell(point.y - lo_.y)) << 1 |
           spread_bits(cell(point.z - lo_.z)) << 2;
  }

 private:
  /// The cell at a distance from the lower bound; the first one if there is no extent, or the
  /// distance is not finite.
  std::uint64_t cell(double distance) const {
    constexpr double kCells = std::uint64_t{1} << kAxisBits;
    const double at = distance / extent_ * kCells;
    return at > 0 ? static_cast<std::uint64_t>(std::min(at, kCells - 1)) : 0;
  }

  Vec3d lo_;
  double extent_;
};

/// The instances that rays can meet, by code and id, with their boxes relative to `origin`.
std::vector<Placed> in_morton_order(const revision::Snapshot& snapshot, const Vec3d& origin) {
  std::vector<Placed> placed;
  std::vector<Vec3d> centers;
  model::DoubleBox box;
  hierarchy::for_each_reached(snapshot.hierarchy(), [&](const model::Node& node,
                                                        const model::Affine& world,
                                                        const model::Affine& back) {
    placed.push_back({0, &node, instances::instance_box(world, back, node.mesh->bounds(), origin)});
    centers.push_back(center_of(world, node));
    if (is_finite(centers.back())) box.grow(centers.back());
  });
  const Grid grid(box);
  for (std::size_t i = 0; i < placed.size(); ++i) placed[i].code = grid.code(centers[i]);
  std::sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
    return a.code != b.code ? a.code < b.code : a.node->id < b.node->id;
  });
  return placed;
}

std::uint64_t weight(const model::Node& node) { return node.mesh->triangles(); }

/// Mixes a number into a hash: a step of FNV-1a, over 64 bits at a time, and a rotation, so that
/// high bits count too.
void mix(std::uint64_t& hash, std::uint64_t number) {
  hash = std::rotl((hash ^ number) * 0x100000001b3, 29);
}

}  // namespace

ShardCut::ShardCut(const revision::Snapshot& snapshot, std::uint32_t shards)
    : center_(snapshot.trees().static_tree().center()), ranges_(shards) {
  assert(shards >= 1 && shards <= kMaxShards);
  const std::vector<Placed> placed = in_morton_order(snapshot, center_);
  std::uint64_t total = 0, before = 0;
  for (const Placed& p : placed) total += weight(*p.node);
  std::vector<std::pair<model::NodeId, std::uint8_t>> table;
  table.reserve(placed.size());
  for (const Placed& p : placed) {
    // An instance belongs to the shard where its middle falls, in Morton order, so that ranges stay
    // compact.
    const std::uint64_t own = weight(*p.node);
    const double middle = static_cast<double>(before) + 0.5 * static_cast<double>(own);
    const auto shard = std::min(
        static_cast<std::uint32_t>(middle / static_cast<double>(total) * shards), shards - 1);
    before += own;
    Range& range = ranges_[shard];
    range.box.grow(p.box);
    ++range.instances;
    range.triangles += own;
    table.emplace_back(p.node->id, static_cast<std::uint8_t>(shard));
  }
  std::sort(table.begin(), table.end());
  bounds_.grow(accel::geometry::Vec3f{});
  for (const Range& range : ranges_) {
    if (range.instances > 0) bounds_.grow(range.box);
  }
  instances_.reserve(table.size());
  shards_.reserve(table.size());
  mix(fingerprint_, kRules);
  mix(fingerprint_, shards);
  for (const auto& [node, shard] : table) {
    instances_.push_back(node);
    shards_.push_back(shard);
    mix(fingerprint_, node);
    mix(fingerprint_, shard);
  }
}

std::uint32_t ShardCut::shard_of(model::NodeId instance) const {
  const auto at = std::lower_bound(instances_.begin(), instances_.end(), instance);
  if (at == instances_.end() || *at != instance) return size();
  return shards_[static_cast<std::size_t>(at - instances_.begin())];
}

bool ShardRay::begin(const accel::geometry::Ray& ray) {
  in_bounds_ = false;
  if (!accel::geometry::set_local_ray(ray.origin - cut_.center(), ray.direction, local_) ||
      std::isnan(ray.tmin) || std::isnan(ray.tmax))
    return false;
  tmax_ = ray.tmax;
  if (points_) return true;
  // The slack is that of bounds that hold the center: it covers the rounding of the subtraction.
  in_bounds_ = accel::kdtree::enter(local_, cut_.bounds(), ray.tmin / local_.unit,
                                    ray.tmax / local_.unit, ray_);
  return true;
}

bool ShardRay::may_meet(std::uint32_t shard, double tmax) const {
  if (points_) return cut_[shard].instances > 0 && distance(cut_[shard].box) <= tmax;
  return in_bounds_ && cut_[shard].instances > 0 &&
         accel::kdtree::may_meet(ray_, cut_[shard].box, tmax / local_.unit + ray_.slack);
}

/// A distance before anything of the box, or the box's exactly if the point is in it.
double ShardRay::distance(const Aabb& box) const {
  Vec3d gap;
  double largest = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const double x = local_.origin[a], lo = static_cast<double>(box.lo[a]),
                 hi = static_cast<double>(box.hi[a]);
    gap[a] = std::max({lo - x, x - hi, 0.0});
    largest = std::max({largest, std::fabs(x), std::fabs(lo), std::fabs(hi)});
  }
  // The subtraction of the center, the gaps, and their length have some ten roundings.
  return std::max(length(gap) - 0x1p-48 * largest, 0.0);
}

/// A t before anything that the ray may hit in the box.
double ShardRay::entry(const Aabb& box) const {
  double entry = ray_.t_in;
  for (std::size_t a = 0; a < 3; ++a) {
    const float near = ray_.first[a] == 1 ? box.hi[a] : box.lo[a];
    const double t = (static_cast<double>(near) - local_.origin[a]) * ray_.inverse[a] - ray_.slack;
    if (t > entry) entry = t;
  }
  return entry;
}

const std::vector<std::uint8_t>& ShardRay::by_entry() {
  entries_.clear();
  order_.clear();
  for (std::uint32_t shard = 0; shard < cut_.size(); ++shard) {
    const Aabb& box = cut_[shard].box;
    if (may_meet(shard, tmax_))
      entries_.emplace_back(points_ ? distance(box) : entry(box), static_cast<std::uint8_t>(shard));
  }
  std::sort(entries_.begin(), entries_.end());
  for (const auto& [at, shard] : entries_) order_.push_back(shard);
  return order_;
}

}  // namespace sightline::scenegraph::query
