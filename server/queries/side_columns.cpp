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

/// Copies values into a column, if it is asked for, from a byte on. A batch may be empty.
template <class T>
void put(std::string* column, std::size_t at, std::span<const T> values) {
  if (column == nullptr || values.empty()) return;
  std::memcpy(column->data() + at, values.data(), values.size_bytes());
}

}  // namespace

std::size_t side_bytes(const CastQuery& query, std::size_t points, std::size_t slice) {
  constexpr std::size_t kReply = sizeof(double) + 2;
  // A slice keeps each point a second time, in order, with its index, two tallies, a distance, and
  // what is found. It has as many crossings as others have points.
  constexpr std::size_t kSlice = sizeof(accel::geometry::Ray) + sizeof(std::uint64_t) +
                                 2 * sizeof(scenegraph::RayTally) + 2 * sizeof(double) +
                                 sizeof(std::uint32_t);
  const std::size_t crossings = query.crossings ? query.sides->rays * sizeof(std::uint32_t) : 0;
  return points * (kReply + crossings) + slice * kSlice;
}

void SideColumns::begin(v1::CastRaysResponse& reply, const CastQuery& query, std::size_t points) {
  signed_ = inside_ = votes_ = crossings_ = nullptr;
  for (v1::HitColumn& column : *reply.mutable_columns()) {
    if (column.field() == v1::HIT_FIELD_SIGNED) signed_ = column.mutable_data();
    if (column.field() == v1::HIT_FIELD_INSIDE) inside_ = column.mutable_data();
    if (column.field() == v1::HIT_FIELD_VOTES) votes_ = column.mutable_data();
    if (column.field() == v1::HIT_FIELD_CROSSINGS) crossings_ = column.mutable_data();
  }
  if (crossings_ != nullptr) crossings_->resize(points * query.sides->rays * sizeof(std::uint32_t));
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
  votes_of_.resize(votes_ != nullptr ? points.size : 0);
  crossings_of_.resize(crossings_ != nullptr ? points.size * question.rays : 0);
  auto found = scenegraph::find_sides(snapshot, points, question,
                                      {sides_, votes_of_, crossings_of_}, options);
  if (!found) return found;
  write(sides_, votes_of_, hits, first);
  put(crossings_, first * question.rays * sizeof(std::uint32_t),
      std::span<const std::uint32_t>(crossings_of_));
  return found;
}

void SideColumns::write(std::span<const Side> sides, std::span<const std::uint8_t> votes,
                        const accel::geometry::HitColumns& hits, std::size_t first) {
  static_assert(sizeof(Side) == 1);
  put(inside_, first, sides);
  put(votes_, first, votes);
  if (signed_ == nullptr) return;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    double distance;
    std::memcpy(&distance, hits.t.at(i), sizeof(distance));
    distance = signed_distance(distance, sides[i]);
    std::memcpy(signed_->data() + (first + i) * sizeof(distance), &distance, sizeof(distance));
  }
}

}  // namespace sightline::server::queries
