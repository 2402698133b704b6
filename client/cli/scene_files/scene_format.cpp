// A table of suffixes.
#include "client/cli/scene_files/scene_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "client/cli/terminal.h"

namespace sightline::client::cli::scene_files {

Result<SceneFormat> scene_format_of(const std::string& path) {
  std::string suffix = std::filesystem::path(path).extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (suffix == ".glb") return SceneFormat::kGlb;
  if (suffix == ".obj") return SceneFormat::kObj;
  return local_error(
      fmt::format("{}: scenes are written as .glb, with their nodes, or as .obj", path));
}

}  // namespace sightline::client::cli::scene_files
