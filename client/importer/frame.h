// The frame of a scene, up axis and unit: what a file says of it, and the turn into the one asked
// for.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "client/importer/imported_scene.h"
#include "client/types.h"

struct aiScene;

namespace sightline::client::importer {

struct Frame {
  UpAxis up_axis = UpAxis::kUnknown;
  double meters_per_unit = 0;  ///< 0: unknown.
};

/// The frame of the arrays that Assimp's importer of this name has made. glTF, Collada and IFC
/// arrive with y up and in metres, FBX as its header says; other formats do not say.
Frame frame_of(const aiScene& scene, std::string_view importer_name);

/// Brings the scene into the frame asked for by changing the transforms of its roots, and records
/// it. What the scene does not know of itself is recorded as asked, and nothing is changed for it.
void convert_frame(ImportedScene& scene, std::optional<UpAxis> up_axis,
                   std::optional<double> meters_per_unit);

/// What convert_frame will put before the transforms of the scene's roots.
Transform frame_conversion(const ImportedScene& scene, std::optional<UpAxis> up_axis,
                           std::optional<double> meters_per_unit);

}  // namespace sightline::client::importer
