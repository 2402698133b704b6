// What a scene loses as Assimp holds it in float32. Internal to the importer.
#pragma once

#include <functional>

#include "client/importer/file_scene.h"

namespace sightline::client::importer {

/// How far Assimp has moved a node by rounding, in its parent's units.
using LossOfNode = std::function<double(const FileNode& node)>;

/// Warns of meshes that are moved by more than kWarnedLoss (rebase.h) of their size, or may be:
/// with their nodes, or as their vertices lie so far from zero.
void warn_of_float_losses(const LossOfNode& loss_of_node, FileScene& scene);

}  // namespace sightline::client::importer
