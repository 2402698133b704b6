// From the bytes of a file to plain arrays: check, read, convert, turn, and move near the origin.
#include "client/importer/read_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <iterator>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "client/importer/animation_from_assimp.h"
#include "client/importer/completeness.h"
#include "client/importer/encoding.h"
#include "client/importer/extension.h"
#include "client/importer/frame.h"
#include "client/importer/lattice.h"
#include "client/importer/preflight.h"
#include "client/importer/scene_from_assimp.h"

namespace sightline::client::importer {
namespace {

template <class Scene>
using Convert = Result<Scene> (*)(const aiScene&, std::string_view, const ImportOptions&);

// A binary STL file without facets, which Assimp refuses.
bool is_empty_stl(const std::string& name, std::string_view bytes) {
  constexpr std::size_t kHeader = 80;
  constexpr std::string_view kNoFacets("\0\0\0\0", 4);
  return extension_of(name) == "stl" && bytes.size() == kHeader + kNoFacets.size() &&
         bytes.ends_with(kNoFacets);
}

std::unique_ptr<const aiScene> scene_without_meshes() {
  auto scene = std::make_unique<aiScene>();
  scene->mRootNode = std::make_unique<aiNode>().release();
  return scene;
}

template <class Scene>
Result<Scene> read(const std::string& name, const FileSource& files, const ImportOptions& options,
                   const ImportProgress& progress, Convert<Scene> convert) {
  const auto bytes = files(name);
  if (!bytes) return import_error("cannot be read");
  if (const Status good = check_encoding(*bytes); !good) return good.error();
  if (const Status good = preflight(name, *bytes); !good) return good.error();
  auto doubts = check_complete(name, *bytes);
  if (!doubts) return doubts.error();
  if (is_empty_stl(name, *bytes)) return convert(*scene_without_meshes(), {}, options);
  const auto source = AssimpFile::read(name, files, progress);
  if (!source) return source.error();
  auto scene = convert(source->scene(), source->importer_name(), options);
  if (!scene) return scene;
  std::vector<std::string>& warnings = warnings_of(*scene);
  warnings = *std::move(doubts);
  std::string turned = turned_axes(source->importer_name(), *bytes, options.up_axis);
  if (!turned.empty()) warnings.push_back(std::move(turned));
  const std::vector<std::string>& complaints = source->complaints();
  std::transform(complaints.begin(), complaints.end(), std::back_inserter(warnings),
                 [](const std::string& complaint) { return "Assimp: " + complaint; });
  return scene;
}

template <class Scene>
Result<Scene> read_or_refuse(const std::string& name, const FileSource& files,
                             const ImportOptions& options, const ImportProgress& progress,
                             Convert<Scene> convert) {
  try {
    return read(name, files, options, progress, convert);
  } catch (const std::exception& e) {
    return import_error(fmt::format("damaged, or not understood by Assimp ({})", e.what()));
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

Result<ImportedScene> read_scene(const std::string& name, const FileSource& files,
                                 const ImportOptions& options, const ImportProgress& progress) {
  return read_or_refuse(name, files, options, progress, convert_scene);
}

Result<AnimatedScene> read_animated_scene(const std::string& name, const FileSource& files,
                                          const ImportOptions& options,
                                          const ImportProgress& progress) {
  return read_or_refuse(name, files, options, progress, convert_animated_scene);
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
