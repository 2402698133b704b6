// Affine maps in double, as rows of [linear | translation].
#pragma once

#include "client/importer/animation.h"

namespace sightline::client::importer {

Transform operator*(const Transform& a, const Transform& b);
Point operator*(const Transform& m, const Point& p);

/// Not finite where there is none.
Transform inverse(const Transform& m);

/// Scaled, then rotated, then moved.
Transform compose(const Point& position, const Quaternion& rotation, const Point& scaling);

}  // namespace sightline::client::importer
