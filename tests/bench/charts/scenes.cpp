// The scenes of the study of speed against accuracy.
#include "tests/bench/charts/scenes.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>

#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

namespace fs = std::filesystem;

// A scan, two rooms and a hall, a small thing in a large scene, leaves that every plane cuts.
constexpr std::array<std::string_view, 6> kUsualScenes{"bunny.ply",        "sibenik.ply",
                                                       "sponza.glb",       "conference.ply",
                                                       "fairy_forest.ply", "japanese_maple.glb"};

Error invalid(std::string message) {
  return {Code::kInvalidArgument, std::move(message), "COMMAND_LINE"};
}

bool generated(const std::string& scene) { return scene.starts_with("gen:"); }

bool same_scene(const std::string& a, const std::string& b) {
  if (a == b) return true;
  std::error_code ignored;
  return !generated(a) && !generated(b) && fs::equivalent(a, b, ignored);
}

Result<std::vector<std::string>> usual_scenes() {
  const char* folder = std::getenv("SIGHTLINE_SCENES");
  if (folder == nullptr || *folder == '\0') {
    return invalid("no scenes: give --scenes FILE ..., or set SIGHTLINE_SCENES to their folder");
  }
  std::vector<std::string> files;
  for (const std::string_view name : kUsualScenes)
    files.push_back((fs::path(folder) / name).string());
  return files;
}

Status check_names(const std::vector<std::string>& scenes) {
  for (auto scene = scenes.begin(); scene != scenes.end(); ++scene) {
    std::error_code ignored;
    if (!generated(*scene) && !fs::is_regular_file(*scene, ignored)) {
      return Error{Code::kNotFound, fmt::format("no scene file {}", *scene), "SCENE_FILE"};
    }
    for (auto before = scenes.begin(); before != scene; ++before) {
      if (!same_scene(*before, *scene)) continue;
      return invalid(*before == *scene
                         ? fmt::format("scene {} is given twice", *scene)
                         : fmt::format("scenes {} and {} are one file", *before, *scene));
    }
  }
  return {};
}

}  // namespace

Result<std::vector<ChartScene>> load_chart_scenes(const std::vector<std::string>& named,
                                                  const CommonOptions& common) {
  std::vector<std::string> files = named;
  if (files.empty()) {
    auto usual = usual_scenes();
    if (!usual.ok()) return usual.error();
    files = std::move(usual).value();
  }
  if (auto good = check_names(files); !good.ok()) return good.error();
  std::vector<ChartScene> scenes;
  for (const std::string& file : files) {
    CommonOptions one = common;
    one.scene = file;
    auto scene = make_scene(one);
    if (!scene.ok()) return scene.error();
    if (scene->unique_triangles() == 0) {
      return invalid(fmt::format("scene {} has no triangles", file));
    }
    std::string name = generated(file) ? file : fs::path(file).stem().string();
    const auto taken = [&](const ChartScene& other) { return other.name == name; };
    if (std::any_of(scenes.begin(), scenes.end(), taken)) name = file;
    SceneSource mesh = merged(*scene);
    scenes.push_back({std::move(name), std::move(scene).value(), std::move(mesh)});
  }
  return scenes;
}

}  // namespace sightline::bench
