// The scenes of the study of speed against accuracy.
#pragma once

#include <string>
#include <vector>

#include "accel/result.h"
#include "tests/bench/scenes/scene_source.h"
#include "tests/bench/verbs/options.h"

namespace sightline::bench {

struct ChartScene {
  std::string name;   ///< The file's without folder and ending, or gen:... as given.
  SceneSource scene;  ///< As the file has it.
  /// All its triangles in one mesh in the world, as the papers have their scenes: builders differ
  /// in the tree over it and in nothing else.
  SceneSource mesh;
};

/// The scenes named, turned by --rotate; if none is, six in the folder that SIGHTLINE_SCENES names.
/// Everything is checked before the first is loaded.
/// Errors: kInvalidArgument: neither is given, a scene is named twice, a wrong generator, one
/// without triangles; kNotFound: no such file, or not a scene.
Result<std::vector<ChartScene>> load_chart_scenes(const std::vector<std::string>& named,
                                                  const CommonOptions& common);

}  // namespace sightline::bench
