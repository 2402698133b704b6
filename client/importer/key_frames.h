// The value of a track of key frames at a time.
#pragma once

#include <vector>

#include "client/importer/animation.h"

namespace sightline::client::importer {

/// Interpolates linearly between keys, and rotations by slerp along the shorter arc. A weight that
/// only one of two keys has counts as 0 in the other. Value is Point, Quaternion or
/// std::vector<double>.
template <class Value>
Value sample(const Track<Value>& track, double seconds);

}  // namespace sightline::client::importer
