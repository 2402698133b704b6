// Vertices by blended shapes and by skins. Internal to the importer.
#pragma once

#include <vector>

#include "client/importer/animation.h"

namespace sightline::client::importer {

/// Adds each shape as often as its weight says. A missing weight is 0.
void blend(const Shapes& shapes, const std::vector<double>& weights, std::vector<Point>& points);

/// Moves vertices to where their bones put them. `world`: of all nodes. Vertices without influences
/// stay.
void put_on(const Skin& skin, const Transform& mesh_from_world, const std::vector<Transform>& world,
            std::vector<Point>& points);

}  // namespace sightline::client::importer
