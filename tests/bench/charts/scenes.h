// The scenes of the study of speed against accuracy.
#pragma once

#include <string>
#include <vector>

#include "proto/result.h"
#include "tests/bench/scenes/scene_source.h"
#include "tests/bench/verbs/options.h"

namespace sightline::bench {

struct ChartScene {
  std::string name;   ///< The file's name without folder and extension, or gen:... as given.
  SceneSource scene;  ///< As the file has it.
  /// All its triangles in one mesh in world space, as in the papers: builders differ in the tree
  /// over it and in nothing else.
  SceneSource mesh;
};

/// The named scenes, rotated by --rotate; if none is named, six from the folder SIGHTLINE_SCENES.
/// All names are checked before the first scene is loaded.
/// Errors: kInvalidArgument: no scene is named and SIGHTLINE_SCENES is not set, a scene is named
/// twice, a wrong generator, a scene without triangles; kNotFound: no such file, or not a scene.
Result<std::vector<ChartScene>> load_chart_scenes(const std::vector<std::string>& named,
                                                  const CommonOptions& common);

}  // namespace sightline::bench
