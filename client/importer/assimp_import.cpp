// From a file to plain arrays: read, convert, turn, and move near the origin.
#include "client/importer/assimp_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <exception>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "client/importer/animation_from_assimp.h"
#include "client/importer/assimp_file.h"
#include "client/importer/frame.h"
#include "client/importer/lattice.h"
#include "client/importer/preflight.h"
#include "client/importer/scene_from_assimp.h"

namespace sightline::client::importer {
namespace {

Error in_file(const std::filesystem::path& file, const Error& error) {
  return import_error(fmt::format("{}: {}", file.string(), error.message));
}

Status check(const std::filesystem::path& file, const ImportOptions& options) {
  if (options.meters_per_unit &&
      !(*options.meters_per_unit > 0 && std::isfinite(*options.meters_per_unit))) {
    return import_error(
        fmt::format("meters per unit is {}, must be above 0", *options.meters_per_unit));
  }
  return check_readable(file);
}

template <class Scene>
using Convert = Result<Scene> (*)(const aiScene&, std::string_view, const ImportOptions&);

template <class Scene>
Result<Scene> read(const std::filesystem::path& file, const ImportOptions& options,
                   const ImportProgress& progress, Convert<Scene> convert) {
  if (const Status good = check(file, options); !good) return good.error();
  try {
    if (const Status good = preflight(file); !good) return in_file(file, good.error());
    const auto source = AssimpFile::read(file, progress);
    if (!source) return source.error();
    auto scene = convert(source->scene(), source->importer_name(), options);
    if (!scene) return in_file(file, scene.error());
    return scene;
  } catch (const std::exception& e) {
    return import_error(fmt::format("{}: {}", file.string(), e.what()));
  }
}

// The result is in the frame that the file states.
Result<ConvertedScene> convert(const aiScene& source, std::string_view importer_name) {
  auto converted = scene_from_assimp(source);
  if (!converted) return converted;
  const Frame frame = frame_of(source, importer_name);
  converted->scene.up_axis = frame.up_axis;
  converted->scene.meters_per_unit = frame.meters_per_unit;
  return converted;
}

Status put_into_frame(ImportedScene& scene, const ImportOptions& options) {
  const double unit = scene.meters_per_unit;
  convert_frame(scene, options.up_axis, options.meters_per_unit);
  for (const ImportedNode& node : scene.nodes) {
    const auto& rows = node.parent_from_local;
    if (std::all_of(rows.begin(), rows.end(), [](double x) { return std::isfinite(x); })) continue;
    return import_error(
        fmt::format("node '{}': its transform is not finite once it is brought from {} m a "
                    "unit to {} m",
                    node.name, unit, scene.meters_per_unit));
  }
  return {};
}

}  // namespace

// Assimp reports every problem with a path as "unable to open"; the system knows more.
Status check_readable(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    return import_error(fmt::format("{}: is a directory", file.string()));
  }
  if (!std::ifstream(file, std::ios::binary)) {
    return import_error(
        fmt::format("{}: {}", file.string(), std::generic_category().message(errno)));
  }
  return {};
}

Result<ImportedScene> import_unrebased(const std::filesystem::path& file,
                                       const ImportOptions& options,
                                       const ImportProgress& progress) {
  return read(file, options, progress, convert_scene);
}

Result<ImportedScene> import_scene(const std::filesystem::path& file, const ImportOptions& options,
                                   const ImportProgress& progress) {
  auto scene = import_unrebased(file, options, progress);
  if (scene) rebase(*scene);
  return scene;
}

Result<AnimatedScene> import_animated_scene(const std::filesystem::path& file,
                                            const ImportOptions& options,
                                            const ImportProgress& progress) {
  return read(file, options, progress, convert_animated_scene);
}

Result<ImportedScene> convert_scene(const aiScene& source, std::string_view importer_name,
                                    const ImportOptions& options) {
  auto converted = convert(source, importer_name);
  if (!converted) return converted.error();
  if (const Status good = put_into_frame(converted->scene, options); !good) return good.error();
  return std::move(converted->scene);
}

Result<AnimatedScene> convert_animated_scene(const aiScene& source, std::string_view importer_name,
                                             const ImportOptions& options) {
  auto converted = convert(source, importer_name);
  if (!converted) return converted.error();
  auto animated = animation_from_assimp(source, *std::move(converted));
  if (!animated) return animated;
  animated->rig.scene_from_file =
      frame_conversion(animated->scene, options.up_axis, options.meters_per_unit);
  if (const Status good = put_into_frame(animated->scene, options); !good) return good.error();
  animated->rig.offset = rebase(animated->scene);
  return animated;
}

}  // namespace sightline::client::importer
