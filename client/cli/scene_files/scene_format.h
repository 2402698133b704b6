// The formats of scene files that the command writes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::cli::scene_files {

enum class SceneFormat : std::uint8_t { kGlb, kObj };

/// What the suffix of a path says, in either case. Errors: kInvalidArgument, another suffix.
Result<SceneFormat> scene_format_of(const std::string& path);

/// Takes the next bytes of a file.
using ByteSink = std::function<Status(std::string_view)>;

/// glTF in binary, y up and in metres: a scene whose axis or unit is known is turned and scaled by
/// the places of its roots. Faces keep their numbers. Errors: those of the sink; kInvalidArgument,
/// more than 4 GiB.
Status write_glb(const importer::ImportedScene& scene, const ByteSink& sink);

/// Text: an object for each node with a mesh, in scene coordinates, as double. An object is named
/// as its node, and NAME#1, NAME#2, ... where nodes share a name. Faces without a
/// triangle are left out. Errors: those of the sink.
Status write_obj(const importer::ImportedScene& scene, const ByteSink& sink);

}  // namespace sightline::client::cli::scene_files
