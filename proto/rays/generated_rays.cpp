// Makes the rays of a generator, range by range.
#include "proto/rays/generated_rays.h"

namespace sightline::proto::rays {

void GeneratedRays::begin(RayGenerator generator) {
  generator_ = std::move(generator);
  size_ = count_of(generator_);
  levels_.clear();
  const auto* scan = std::get_if<SphericalScan>(&generator_.rays);
  if (scan == nullptr) return;
  levels_.resize(std::min<std::size_t>(scan->columns, size_));
  std::uint64_t column = generator_.first % scan->columns;
  for (Vector& level : levels_) {
    const SineCosine turn = sine_cosine(middle(scan->azimuth, column, scan->columns));
    level = sum({}, turn.cosine, scan->forward, turn.sine, scan->left);
    if (++column == scan->columns) column = 0;
  }
}

}  // namespace sightline::proto::rays
