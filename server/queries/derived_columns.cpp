// Columns of a reply that follow from others: positions from t, names from nodes.
#include "server/queries/derived_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "scenegraph/query/surface.h"

namespace sightline::server::queries {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitColumns;
using accel::geometry::Ray;
using accel::geometry::RayColumns;
using accel::geometry::Vec3d;
using scenegraph::RayTally;
using scenegraph::model::NodeId;

/// Bytes of a name's tag and length.
constexpr std::size_t kNameHeader = 3;
/// Bytes that a name takes while a reply is made, beside its characters.
constexpr std::size_t kNameEntry = 128;

template <class T>
T value(const accel::geometry::FieldColumn<T>& column, std::size_t row) {
  T number;
  std::memcpy(&number, column.at(row), sizeof(T));
  return number;
}

template <class T>
void set(std::string& column, std::size_t row, const T& number) {
  std::memcpy(column.data() + row * sizeof(T), &number, sizeof(T));
}

}  // namespace

std::size_t derived_bytes(const CastQuery& query, std::size_t rows, std::size_t hits) {
  std::size_t bytes = 0;
  if (query.positions) bytes += rows * sizeof(Vec3d);
  if (query.names) {
    const std::size_t characters = std::min(hits * scenegraph::model::kMaxNodeName, kMaxNameBytes);
    bytes += rows * sizeof(std::uint32_t) + hits * kNameEntry + characters;
  }
  return bytes;
}

void DerivedColumns::begin(const scenegraph::revision::Snapshot& snapshot, bool points,
                           v1::CastRaysResponse& columns, v1::CastRaysResponse& reply) {
  snapshot_ = &snapshot;
  points_ = points;
  reply_ = &reply;
  positions_ = names_ = nullptr;
  for (v1::HitColumn& column : *columns.mutable_columns()) {
    if (column.field() == v1::HIT_FIELD_POSITION) positions_ = column.mutable_data();
    if (column.field() == v1::HIT_FIELD_NAME) names_ = column.mutable_data();
  }
  reply.clear_names();
  row_of_node_.clear();
  row_of_name_.clear();
  name_bytes_ = 0;
  if (names_ == nullptr) return;
  reply.add_names();
  row_of_node_.emplace(0, 0);
  row_of_name_.emplace(std::string_view(), 0);
}

void DerivedColumns::add_sources(HitColumns& hits) {
  if (positions_ != nullptr && !hits.t.is_asked()) {
    t_.resize(hits.size);
    hits.t = {t_.data()};
  }
  const bool faces = positions_ != nullptr && points_;
  if ((names_ != nullptr || faces) && !hits.node.is_asked()) {
    nodes_.resize(hits.size);
    hits.node = {nodes_.data()};
  }
  if (faces && !hits.primitive.is_asked()) {
    primitives_.resize(hits.size);
    hits.primitive = {primitives_.data()};
  }
}

Status DerivedColumns::write(const RayColumns& rays, const HitColumns& hits, std::size_t first) {
  if (positions_ != nullptr) {
    Hit hit;
    for (std::size_t i = 0; i < rays.size; ++i) {
      hit.t = value(hits.t, i);
      if (points_) {
        hit.node = value(hits.node, i);
        hit.primitive = value(hits.primitive, i);
      }
      set_position(first + i, rays[i], hit);
    }
  }
  if (names_ == nullptr) return {};
  for (std::size_t i = 0; i < rays.size; ++i) {
    if (Status named = set_name(first + i, value(hits.node, i)); !named) return named;
  }
  return {};
}

Status DerivedColumns::write_lists(std::span<const Ray> rays, std::span<const RayTally> tallies,
                                   std::span<const Hit> hits) {
  if (positions_ != nullptr) {
    std::size_t row = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      for (std::uint32_t k = 0; k < tallies[i].count; ++k, ++row)
        set_position(row, rays[i], hits[row]);
    }
  }
  if (names_ == nullptr) return {};
  for (std::size_t row = 0; row < hits.size(); ++row) {
    if (Status named = set_name(row, hits[row].node); !named) return named;
  }
  return {};
}

void DerivedColumns::end() {
  row_of_node_ = {};
  row_of_name_ = {};
}

void DerivedColumns::set_position(std::size_t row, const Ray& ray, const Hit& hit) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  Vec3d position{kNone, kNone, kNone};
  if (std::isfinite(hit.t) && points_) {
    position = scenegraph::query::nearest_point(*snapshot_, hit.node, hit.primitive, ray.origin);
  } else if (std::isfinite(hit.t)) {
    position = ray.origin + ray.direction * hit.t;
  }
  set(*positions_, row, position);
}

Status DerivedColumns::set_name(std::size_t row, NodeId node) {
  const auto name = find_or_add_name(node);
  if (!name) return name.error();
  set(*names_, row, *name);
  return {};
}

Result<std::uint32_t> DerivedColumns::find_or_add_name(NodeId node) {
  if (const auto known = row_of_node_.find(node); known != row_of_node_.end()) return known->second;
  const scenegraph::model::Node& found = *snapshot_->find(node);
  const auto [named, is_new] =
      row_of_name_.emplace(found.name, static_cast<std::uint32_t>(reply_->names_size()));
  row_of_node_.emplace(node, named->second);
  if (!is_new) return named->second;
  name_bytes_ += found.name.size() + kNameHeader;
  if (name_bytes_ > kMaxNameBytes) {
    return Error{Code::kResourceExhausted,
                 fmt::format("the names of the nodes that are hit take more than {} bytes, the "
                             "limit of a reply; cast fewer rays at a time, or ask for "
                             "HIT_FIELD_NODE, and BatchGetNodes for the names",
                             kMaxNameBytes),
                 "NAMES_TOO_LONG"};
  }
  reply_->add_names(found.name);
  return named->second;
}

}  // namespace sightline::server::queries
