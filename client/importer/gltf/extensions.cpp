// Lists of names, and the check of the version.
#include "client/importer/gltf/extensions.h"

#include <algorithm>
#include <charconv>
#include <system_error>
#include <utility>

namespace sightline::client::importer::gltf {
namespace {

constexpr std::string_view kDone[] = {
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_accessor_float64",
    "KHR_draco_mesh_compression",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    // Its finest level, which is the node itself.
    "MSFT_lod",
};

// Looks, lights, sounds and descriptions. A name that ends in * stands for all that begin with it.
constexpr std::string_view kWithoutGeometry[] = {
    "ADOBE_materials_*",
    "AGI_stk_metadata",
    "CESIUM_primitive_outline",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_lights_*",
    "EXT_materials_*",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_mesh_primitive_edge_visibility",
    "EXT_property_*",
    "EXT_structural_metadata",
    "EXT_texture_*",
    "FB_geometry_metadata",
    "FB_ngon_encoding",
    "GODOT_single_root",
    "GOOGLE_backgrounds",
    "GOOGLE_camera_settings",
    "KHR_animation_clip",
    "KHR_audio*",
    "KHR_blend",
    "KHR_collision_shapes",
    "KHR_data_sizes",
    "KHR_displayencoding*",
    "KHR_displaymapping*",
    "KHR_image_*",
    "KHR_implicit_shapes",
    "KHR_lights_*",
    "KHR_materials_*",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "KHR_technique*",
    "KHR_texture_*",
    "KHR_xmp*",
    "KHR_XMP*",
    "MSFT_audio_emitter",
    "MSFT_collision_primitives",
    "MSFT_packing_*",
    "MSFT_physics_rigid_bodies",
    "MSFT_texture_*",
    "NV_materials_*",
    "OMI_*",
    "PTC_*",
    "VRMC_materials_*",
};

bool matches(std::string_view pattern, std::string_view name) {
  if (!pattern.ends_with('*')) return pattern == name;
  pattern.remove_suffix(1);
  return name.starts_with(pattern);
}

struct Version {
  unsigned major = 0, minor = 0;
};

Version version_of(std::string_view text, std::string_view what) {
  Version out;
  const char* const end = text.data() + text.size();
  const auto [dot, bad_major] = std::from_chars(text.data(), end, out.major);
  if (bad_major == std::errc() && dot != end && *dot == '.') {
    const auto [last, bad_minor] = std::from_chars(dot + 1, end, out.minor);
    if (bad_minor == std::errc() && last == end) return out;
  }
  refuse("{} is '{}', must be a version such as 2.0", what, text.substr(0, 40));
}

[[noreturn]] void refuse_first_version(std::string_view version) {
  refuse(
      "it is glTF {}, which is not read; convert it to glTF 2.0, with gltf-pipeline, for "
      "example",
      version);
}

void check_version(const Document& document) {
  const Item root = document.root();
  // In glTF 1 these are no lists. It may say so or not.
  for (const char* key : {"accessors", "meshes", "nodes", "scenes"}) {
    if (root.has_object(key)) refuse_first_version("1.0");
  }
  const auto asset = root.object("asset");
  if (!asset || !asset->has("version"))
    refuse("its asset.version is missing, which every file of glTF 2.0 has");
  const std::string version = asset->text("version");
  const Version of_file = version_of(version, "asset.version");
  if (of_file.major == 1) refuse_first_version(version);
  if (of_file.major != 2) refuse("it is glTF {}; glTF 2 is read", version);
  if (!asset->has("minVersion")) return;
  const Version least = version_of(asset->text("minVersion"), "asset.minVersion");
  if (std::pair(least.major, least.minor) > std::pair(2U, 0U))
    refuse("its minVersion is {}.{}; glTF 2.0 is read", least.major, least.minor);
}

std::vector<std::string> not_understood(const Document& document, const char* list) {
  std::vector<std::string> names = document.root().texts(list);
  std::erase_if(names, [](const std::string& name) { return is_understood(name); });
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace

bool is_understood(std::string_view extension) {
  const auto is_this = [&](std::string_view pattern) { return matches(pattern, extension); };
  return std::any_of(std::begin(kDone), std::end(kDone), is_this) ||
         std::any_of(std::begin(kWithoutGeometry), std::end(kWithoutGeometry), is_this);
}

std::vector<std::string> check_extensions(const Document& document) {
  check_version(document);
  const std::vector<std::string> required = not_understood(document, "extensionsRequired");
  if (!required.empty()) {
    refuse("it requires the glTF extension{} {}, which {} not read", required.size() > 1 ? "s" : "",
           fmt::join(required, ", "), required.size() > 1 ? "are" : "is");
  }
  return not_understood(document, "extensionsUsed");
}

}  // namespace sightline::client::importer::gltf
