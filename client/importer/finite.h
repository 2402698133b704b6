// Whether the numbers of a vertex, a point or a transform are finite.
#pragma once

#include <algorithm>
#include <cmath>

namespace sightline::client::importer {

template <class Values>
bool is_finite(const Values& values) {
  return std::all_of(values.begin(), values.end(), [](auto x) { return std::isfinite(x); });
}

}  // namespace sightline::client::importer
