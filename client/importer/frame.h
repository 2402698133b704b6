// The frame of a scene (up axis and unit) and its conversion.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "client/importer/imported_scene.h"
#include "client/types.h"

struct aiScene;

namespace sightline::client::importer {

struct Frame {
  UpAxis up_axis = UpAxis::kUnknown;
  double meters_per_unit = 0;  ///< 0: unknown
};

/// The frame of a scene read by Assimp's importer of this name. Collada and IFC have y up and
/// metres there; FBX states its frame in the header; other formats do not state it.
Frame frame_of(const aiScene& scene, std::string_view importer_name);

/// What was turned when a file of an importer of this name was read, with the flag that keeps the
/// file's axes, for people. Assimp turns IFC files and some Collada files so that y is up. Empty:
/// nothing, or `up_axis` was asked for and the file could keep its axes. `bytes`: the file.
std::string turned_axes(std::string_view importer_name, std::string_view bytes,
                        std::optional<UpAxis> up_axis);

/// Converts the scene to the requested frame by changing the transforms of its roots, and records
/// the frame. If the scene's own axis or unit is unknown, the requested one is recorded and nothing
/// changes.
void convert_frame(ImportedScene& scene, std::optional<UpAxis> up_axis,
                   std::optional<double> meters_per_unit);

/// The transform that convert_frame would apply before the transforms of the roots.
Transform frame_conversion(const ImportedScene& scene, std::optional<UpAxis> up_axis,
                           std::optional<double> meters_per_unit);

}  // namespace sightline::client::importer
