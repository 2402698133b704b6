// From a file to plain arrays: read, convert, turn, and move near the origin.
#include "client/importer/assimp_import.h"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>
#include <fstream>
#include <string_view>
#include <utility>

#include "client/importer/assimp_file.h"
#include "client/importer/convert.h"
#include "client/importer/lattice.h"
#include "client/importer/preflight.h"

namespace sightline::client::importer {
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
    return invalid(fmt::format("{}: {}", file.string(), e.what()));
  }
}

}  // namespace

// Assimp reports every problem with a path as "unable to open"; the system knows more.
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

}  // namespace sightline::client::importer
