// Columns of a reply that tell on which side of the scene's surfaces points are.
#include "server/queries/side_columns.h"

#include <cstring>
#include <limits>

namespace sightline::server::queries {
namespace {

using scenegraph::Side;

/// A distance with the sign of its side.
double signed_distance(double distance, Side side) {
  if (side == Side::kInvalid) return std::numeric_limits<double>::quiet_NaN();
  if (side == Side::kUnanswered) return -std::numeric_limits<double>::infinity();
  const bool is_near = distance > 0 && distance < std::numeric_limits<double>::infinity();
  return side == Side::kInside && is_near ? -distance : distance;
}

}  // namespace

std::size_t side_bytes(std::size_t points, std::size_t slice) {
  constexpr std::size_t kReply = sizeof(double) + 2;
  // A slice keeps each point a second time, in order, with its index, two tallies, a distance, and
  // what is found.
  constexpr std::size_t kSlice = sizeof(accel::geometry::Ray) + sizeof(std::uint64_t) +
                                 2 * sizeof(scenegraph::RayTally) + 2 * sizeof(double);
  return points * kReply + slice * kSlice;
}

void SideColumns::begin(v1::CastRaysResponse& reply) {
  signed_ = inside_ = votes_ = nullptr;
  for (v1::HitColumn& column : *reply.mutable_columns()) {
    if (column.field() == v1::HIT_FIELD_SIGNED) signed_ = column.mutable_data();
    if (column.field() == v1::HIT_FIELD_INSIDE) inside_ = column.mutable_data();
    if (column.field() == v1::HIT_FIELD_VOTES) votes_ = column.mutable_data();
  }
}

void SideColumns::add_sources(accel::geometry::HitColumns& hits) {
  if (signed_ == nullptr || hits.t.is_asked()) return;
  t_.resize(hits.size);
  hits.t = {t_.data()};
}

Result<scenegraph::TraceStats> SideColumns::write(const scenegraph::revision::Snapshot& snapshot,
                                                  const accel::geometry::RayColumns& points,
                                                  const scenegraph::SideQuestion& question,
                                                  const scenegraph::TraceOptions& options,
                                                  const accel::geometry::HitColumns& hits,
                                                  std::size_t first) {
  sides_.resize(points.size);
  std::span<std::uint8_t> votes;
  if (votes_ != nullptr)
    votes = {reinterpret_cast<std::uint8_t*>(votes_->data()) + first, points.size};
  auto found = scenegraph::find_sides(snapshot, points, question, {sides_, votes}, options);
  if (!found) return found;
  static_assert(sizeof(Side) == 1);
  if (inside_ != nullptr) std::memcpy(inside_->data() + first, sides_.data(), sides_.size());
  if (signed_ == nullptr) return found;
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    double distance;
    std::memcpy(&distance, hits.t.at(i), sizeof(distance));
    distance = signed_distance(distance, sides_[i]);
    std::memcpy(signed_->data() + (first + i) * sizeof(distance), &distance, sizeof(distance));
  }
  return found;
}

}  // namespace sightline::server::queries
