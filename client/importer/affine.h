// Affine maps in double, as rows of [linear | translation].
#pragma once

#include "client/importer/animation.h"

namespace sightline::client::importer {

Transform operator*(const Transform& a, const Transform& b);
Point operator*(const Transform& m, const Point& p);

/// The inverse; not finite if there is none.
Transform inverse(const Transform& m);

/// Scales, then rotates, then translates.
Transform compose(const Point& position, const Quaternion& rotation, const Point& scaling);

}  // namespace sightline::client::importer
