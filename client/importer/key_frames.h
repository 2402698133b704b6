// The value of a track of key frames at a time.
#pragma once

#include <vector>

#include "client/importer/animation.h"

namespace sightline::client::importer {

/// Linear between keys; rotations by slerp on the shorter arc. Weights that only one of two keys
/// has count 0 in the other. Value is Point, Quaternion or std::vector<double>.
template <class Value>
Value sample(const Track<Value>& track, double seconds);

}  // namespace sightline::client::importer
