// Meshes with skins and shapes as they lie when no animation is played. Internal to the importer.
#pragma once

#include <vector>

#include "client/importer/file_scene.h"

namespace sightline::client::importer {

/// Blends the shapes of all meshes by their weights at rest, and puts meshes with a skin where
/// their bones are. Returns, by mesh, its vertices before that; none for a mesh without skin and
/// shapes.
///
/// Each node with a skin gets a mesh of its own, because a skin is applied in the node's frame. It
/// does not move its meshes: if its scale in the scene is 0 at rest, or may be 0 in an
/// animation, then the mesh moves to a new node of the same name that has no parent, and the node
/// keeps the rest of its meshes. Nodes and bones must be in range.
std::vector<std::vector<Point>> apply_rest_pose(FileScene& scene);

}  // namespace sightline::client::importer
