// Generators of rays and of points to messages.
#include "client/wire/generator_codec.h"

#include <string>
#include <vector>

namespace sightline::client::wire {
namespace {

using Numbers = google::protobuf::RepeatedField<double>;

template <class Range>
void assign(const Range& numbers, Numbers& out) {
  out.Assign(numbers.begin(), numbers.end());
}

/// The bytes of an array of arrays.
template <class Row>
std::string bytes_of(const std::vector<Row>& rows) {
  return {reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(Row)};
}

void encode_kind(const proto::rays::Pinhole& pinhole, v1::RayGenerator& message) {
  v1::Pinhole& out = *message.mutable_pinhole();
  assign(pinhole.eye, *out.mutable_eye());
  assign(pinhole.corner, *out.mutable_corner());
  assign(pinhole.across, *out.mutable_across());
  assign(pinhole.down, *out.mutable_down());
  out.set_width(pinhole.width);
  out.set_height(pinhole.height);
  for (const auto& sample : pinhole.samples) {
    out.add_samples(sample[0]);
    out.add_samples(sample[1]);
  }
  out.set_tiled(pinhole.tiled);
}

void encode_kind(const proto::rays::SphericalScan& scan, v1::RayGenerator& message) {
  v1::SphericalScan& out = *message.mutable_scan();
  assign(scan.origin, *out.mutable_origin());
  assign(scan.forward, *out.mutable_forward());
  assign(scan.left, *out.mutable_left());
  assign(scan.up, *out.mutable_up());
  assign(scan.azimuth, *out.mutable_azimuth());
  assign(scan.elevation, *out.mutable_elevation());
  out.set_columns(scan.columns);
  out.set_rows(scan.rows);
}

void encode_kind(const proto::rays::VisibilityPairs& visibility, v1::RayGenerator& message) {
  v1::VisibilityPairs& out = *message.mutable_pairs();
  out.set_float64(true);
  out.set_from(bytes_of(visibility.from));
  out.set_to(bytes_of(visibility.to));
  out.set_pairs(bytes_of(visibility.pairs));
}

}  // namespace

void encode(const proto::rays::RayGenerator& generator, v1::RayGenerator& message) {
  message.Clear();
  std::visit([&](const auto& kind) { encode_kind(kind, message); }, generator.rays);
  message.set_first(generator.first);
  message.set_count(generator.count);
  message.set_tmin(generator.tmin);
  if (generator.tmax) message.set_tmax(*generator.tmax);
  message.set_mask(generator.mask);
}

void encode(const proto::rays::PointGrid& grid, v1::PointGrid& message) {
  message.Clear();
  assign(grid.origin, *message.mutable_origin());
  assign(grid.across, *message.mutable_across());
  assign(grid.down, *message.mutable_down());
  assign(grid.deep, *message.mutable_deep());
  message.set_columns(grid.columns);
  message.set_rows(grid.rows);
  message.set_layers(grid.layers);
  message.set_first(grid.first);
  message.set_count(grid.count);
  message.set_max_distance(grid.max_distance);
  message.set_mask(grid.mask);
}

}  // namespace sightline::client::wire
