// Converts, then turns and scales. Animated scenes are also moved near the origin.
#include "client/importer/convert.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/importer/animation_from_assimp.h"
#include "client/importer/frame.h"
#include "client/importer/lattice.h"
#include "client/importer/scene_from_assimp.h"

namespace sightline::client::importer {
namespace {

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
    return Error{
        Code::kInvalidArgument,
        fmt::format("node '{}': its transform is not finite once it is brought from {} m a "
                    "unit to {} m",
                    node.name, unit, scene.meters_per_unit),
        {}};
  }
  return {};
}

}  // namespace

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
