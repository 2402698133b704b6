// Whether rays can hit anything of a scene.
#pragma once

#include <string>
#include <string_view>

#include "client/importer/imported_scene.h"

namespace sightline::client::importer {

/// Why no ray can hit the scene, for people: it is a point cloud, say, or its triangles have no
/// area. Empty if a ray can. `file`: the name of the file that it was read from.
std::string why_not_hittable(const ImportedScene& scene, std::string_view file);

}  // namespace sightline::client::importer
