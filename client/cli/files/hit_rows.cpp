// Repeats what belongs to a ray in each row of its hits.
#include "client/cli/files/hit_rows.h"

#include <limits>
#include <span>

namespace sightline::client::cli::files {
namespace {

constexpr std::uint8_t kBadRay = 2;
/// Beyond every list of names.
constexpr std::uint32_t kNoName = std::numeric_limits<std::uint32_t>::max();

template <class T>
void add_rows(std::span<const T> from, std::size_t begin, std::size_t end, std::size_t width,
              std::vector<T>& to) {
  if (from.empty()) return;
  to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(begin * width),
            from.begin() + static_cast<std::ptrdiff_t>(end * width));
}

}  // namespace

RowView HitRows::make(std::uint64_t first, const HitView& hits) {
  ray_.clear();
  node_.clear();
  t_.clear();
  primitive_.clear();
  work_.clear();
  barycentric_.clear();
  position_.clear();
  normal_.clear();
  name_.clear();
  hit_.clear();
  for (std::size_t i = 0; i + 1 < hits.offsets.size(); ++i) {
    if (hits.hit[i] == kBadRay) {
      add_without_hit(std::numeric_limits<double>::quiet_NaN());
    } else if (hits.hit[i] == kUnanswered) {
      add_without_hit(-std::numeric_limits<double>::infinity());
    } else {
      add_hits(hits, i);
    }
    hit_.resize(t_.size(), hits.hit[i]);
    ray_.resize(t_.size(), first + i);
    if (!hits.work.empty()) work_.resize(t_.size(), hits.work[i]);
  }
  RowView rows;
  rows.ray = ray_;
  rows.t = t_;
  rows.node = node_;
  rows.primitive = primitive_;
  rows.barycentric = barycentric_;
  rows.position = position_;
  rows.normal = normal_;
  rows.name = name_;
  rows.names = hits.names;
  rows.hit = hit_;
  rows.work = work_;
  return rows;
}

void HitRows::add_without_hit(double t) {
  t_.push_back(t);
  node_.push_back(0);
  primitive_.push_back(0);
  barycentric_.insert(barycentric_.end(), 2, 0.0F);
  position_.insert(position_.end(), 3, std::numeric_limits<double>::quiet_NaN());
  normal_.insert(normal_.end(), 3, 0.0F);
  name_.push_back(kNoName);
}

void HitRows::add_hits(const HitView& hits, std::size_t i) {
  const std::size_t begin = hits.offsets[i], end = hits.offsets[i + 1];
  if (hits.t.empty()) {
    t_.resize(t_.size() + end - begin);  // counts the rows even if t was not requested
  } else {
    add_rows(hits.t, begin, end, 1, t_);
  }
  add_rows(hits.node, begin, end, 1, node_);
  add_rows(hits.primitive, begin, end, 1, primitive_);
  add_rows(hits.barycentric, begin, end, 2, barycentric_);
  add_rows(hits.position, begin, end, 3, position_);
  add_rows(hits.normal, begin, end, 3, normal_);
  add_rows(hits.name, begin, end, 1, name_);
}

}  // namespace sightline::client::cli::files
