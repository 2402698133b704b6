// Resource names: projects/{project}/scenes/{scene}.
#include "server/scenes/names.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/exec/rpc_status.h"

namespace sightline::server::scenes {
namespace {

constexpr std::string_view kProjects = "projects/";
constexpr std::string_view kScenes = "/scenes/";

Error bad_name(std::string_view name, std::string_view shape) {
  return {Code::kInvalidArgument,
          fmt::format("{} is not a name of the form {}", exec::quote(name), shape),
          "BAD_RESOURCE_NAME"};
}

Status check_id(std::string_view what, std::string_view id) {
  if (is_id(id)) return {};
  return Error{
      Code::kInvalidArgument,
      fmt::format("{} id {} does not match [a-z0-9][a-z0-9._-]{{0,62}}", what, exec::quote(id)),
      "BAD_RESOURCE_NAME"};
}

}  // namespace

bool is_id(std::string_view text) {
  const auto alphanumeric = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
  return !text.empty() && text.size() <= kMaxId && alphanumeric(text.front()) &&
         std::all_of(text.begin(), text.end(),
                     [&](char c) { return alphanumeric(c) || c == '.' || c == '_' || c == '-'; });
}

Status check_scene_name(std::string_view name) {
  const std::size_t scenes = name.find(kScenes);
  if (!name.starts_with(kProjects) || scenes == std::string_view::npos ||
      scenes < kProjects.size()) {
    return bad_name(name, "projects/{project}/scenes/{scene}");
  }
  if (Status project = check_project_name(name.substr(0, scenes)); !project) return project;
  return check_id("scene", name.substr(scenes + kScenes.size()));
}

Status check_project_name(std::string_view name) {
  if (!name.starts_with(kProjects)) return bad_name(name, "projects/{project}");
  return check_id("project", name.substr(kProjects.size()));
}

std::string_view project_of(std::string_view scene_name) {
  return scene_name.substr(0, scene_name.find(kScenes));
}

}  // namespace sightline::server::scenes
