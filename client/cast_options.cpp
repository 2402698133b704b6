// Appends the answers of a message to the hits of all rays.
#include "client/cast_options.h"

#include <span>

namespace sightline::client {
namespace {

template <class T>
void add(std::span<const T> rows, std::vector<T>& to) {
  to.insert(to.end(), rows.begin(), rows.end());
}

}  // namespace

void AllHits::append(const HitView& hits) {
  if (offsets.empty()) offsets.push_back(0);
  const std::uint64_t before = offsets.back();
  for (std::size_t i = 1; i < hits.offsets.size(); ++i) offsets.push_back(before + hits.offsets[i]);
  add(hits.hit, hit);
  add(hits.work, work);
  add(hits.t, t);
  add(hits.node, node);
  add(hits.primitive, primitive);
  add(hits.barycentric, barycentric);
  add(hits.normal, normal);
  add(hits.position, position);
  for (const std::uint32_t row : hits.name) name.emplace_back(hits.names[row]);
}

}  // namespace sightline::client
