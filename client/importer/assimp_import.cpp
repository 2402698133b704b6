// From a file to plain arrays: read, converted, turned, brought near the origin.
#include "client/importer/assimp_import.h"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>
#include <fstream>
#include <utility>

#include "client/importer/animation_from_assimp.h"
#include "client/importer/assimp_file.h"
#include "client/importer/frame.h"
#include "client/importer/lattice.h"
#include "client/importer/scene_from_assimp.h"

namespace sightline::client {
namespace {

Error invalid(std::string message) { return {Code::kInvalidArgument, std::move(message), {}}; }

Error in_file(const std::filesystem::path& file, const Error& error) {
  return invalid(fmt::format("{}: {}", file.string(), error.message));
}

Status check(const std::filesystem::path& file, const ImportOptions& options) {
  if (options.meters_per_unit &&
      !(*options.meters_per_unit > 0 && std::isfinite(*options.meters_per_unit))) {
    return invalid(fmt::format("meters per unit is {}, must be above 0", *options.meters_per_unit));
  }
  return check_readable(file);
}

// With the frame that the file says it has.
Result<ConvertedScene> convert(const AssimpFile& source) {
  auto converted = scene_from_assimp(source.scene());
  if (!converted) return converted;
  const Frame frame = frame_of(source.scene(), source.importer_name());
  converted->scene.up_axis = frame.up_axis;
  converted->scene.meters_per_unit = frame.meters_per_unit;
  return converted;
}

Result<AnimatedScene> read_animated(const std::filesystem::path& file, const ImportOptions& options,
                                    const ImportProgress& progress) {
  const auto source = AssimpFile::read(file, progress);
  if (!source) return source.error();
  auto converted = convert(*source);
  if (!converted) return in_file(file, converted.error());
  auto animated = animation_from_assimp(source->scene(), *std::move(converted));
  if (!animated) return in_file(file, animated.error());
  animated->rig.scene_from_file =
      frame_conversion(animated->scene, options.up_axis, options.meters_per_unit);
  convert_frame(animated->scene, options.up_axis, options.meters_per_unit);
  animated->rig.offset = rebase(animated->scene);
  return animated;
}

Result<ImportedScene> read(const std::filesystem::path& file, const ImportOptions& options,
                           const ImportProgress& progress) {
  const auto source = AssimpFile::read(file, progress);
  if (!source) return source.error();
  auto converted = convert(*source);
  if (!converted) return in_file(file, converted.error());
  convert_frame(converted->scene, options.up_axis, options.meters_per_unit);
  return std::move(converted->scene);
}

}  // namespace

// Assimp says "unable to open" for whatever is wrong with a path; the system knows more.
Status check_readable(const std::filesystem::path& file) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) {
    return invalid(fmt::format("{}: is a directory", file.string()));
  }
  if (!std::ifstream(file, std::ios::binary)) {
    return invalid(fmt::format("{}: {}", file.string(), std::strerror(errno)));
  }
  return {};
}

Result<ImportedScene> import_unrebased(const std::filesystem::path& file,
                                       const ImportOptions& options,
                                       const ImportProgress& progress) {
  if (const Status good = check(file, options); !good) return good.error();
  try {
    return read(file, options, progress);
  } catch (const std::exception& e) {
    return invalid(fmt::format("{}: {}", file.string(), e.what()));
  }
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
  if (const Status good = check(file, options); !good) return good.error();
  try {
    return read_animated(file, options, progress);
  } catch (const std::exception& e) {
    return invalid(fmt::format("{}: {}", file.string(), e.what()));
  }
}

}  // namespace sightline::client
