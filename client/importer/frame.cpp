// Reads the frame of a file, and turns a scene into another frame.
#include "client/importer/frame.h"

#include <assimp/scene.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdint>

namespace sightline::client::importer {
namespace {

constexpr double kMetersPerCentimeter = 0.01;

Frame frame_of_fbx(const aiScene& scene) {
  Frame frame;
  if (scene.mMetaData == nullptr) return frame;
  std::int32_t up = -1;
  if (scene.mMetaData->Get("UpAxis", up)) {
    if (up == 1) frame.up_axis = UpAxis::kY;
    if (up == 2) frame.up_axis = UpAxis::kZ;
  }
  double centimeters = 0;
  if (float single = 0; scene.mMetaData->Get("UnitScaleFactor", single)) {
    centimeters = static_cast<double>(single);
  } else {
    scene.mMetaData->Get("UnitScaleFactor", centimeters);
  }
  if (centimeters > 0 && std::isfinite(centimeters))
    frame.meters_per_unit = centimeters * kMetersPerCentimeter;
  return frame;
}

// The word in the first up_axis element of a Collada file; empty if there is none.
std::string_view stated_up(std::string_view bytes) {
  constexpr std::string_view kElement = "<up_axis>", kBlanks = " \t\r\n";
  const std::size_t begin = bytes.find(kElement);
  if (begin == std::string_view::npos) return {};
  std::string_view text = bytes.substr(begin + kElement.size(), 32);
  text = text.substr(0, text.find('<'));
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) + 1 - first);
}

void set_row(std::array<double, 12>& m, std::size_t to, const std::array<double, 12>& from,
             std::size_t row, double factor) {
  for (std::size_t k = 0; k < 4; ++k) m[to * 4 + k] = factor * from[row * 4 + k];
}

// Turns y up to z up: (x, y, z) -> (x, -z, y); or z up to y up: (x, y, z) -> (x, z, -y).
void turn(std::array<double, 12>& m, UpAxis to) {
  const std::array<double, 12> old = m;
  const bool to_z = to == UpAxis::kZ;
  set_row(m, 1, old, 2, to_z ? -1.0 : 1.0);
  set_row(m, 2, old, 1, to_z ? 1.0 : -1.0);
}

}  // namespace

Frame frame_of(const aiScene& scene, std::string_view importer_name) {
  const auto is = [&](std::string_view word) {
    return importer_name.find(word) != std::string_view::npos;
  };
  if (is("Collada") || is("IFC")) return {UpAxis::kY, 1.0};
  if (is("FBX")) return frame_of_fbx(scene);
  return {};
}

std::string turned_axes(std::string_view importer_name, std::string_view bytes,
                        std::optional<UpAxis> up_axis) {
  const bool is_ifc = importer_name.find("IFC") != std::string_view::npos;
  const bool is_collada = importer_name.find("Collada") != std::string_view::npos;
  const std::string_view stated = is_collada ? stated_up(bytes) : std::string_view();
  if (is_collada && stated == "X_UP") {
    const bool to_z = up_axis == UpAxis::kZ;
    return fmt::format(
        "its x axis is up, which no scene here can have: (x, y, z) of the file is {} here, so that "
        "{} is up",
        to_z ? "(-y, -z, x)" : "(-y, x, z)", to_z ? "z" : "y");
  }
  if (up_axis || (!is_ifc && stated != "Z_UP")) return {};
  return "its z axis is up, and Assimp has turned it: (x, y, z) of the file is (x, z, -y) here, so "
         "that y is up; --up z keeps the file's axes, --up y is silent";
}

void convert_frame(ImportedScene& scene, std::optional<UpAxis> up_axis,
                   std::optional<double> meters_per_unit) {
  const UpAxis up = up_axis.value_or(scene.up_axis);
  const double unit = meters_per_unit.value_or(scene.meters_per_unit);
  const bool turned = up != scene.up_axis && scene.up_axis != UpAxis::kUnknown;
  const bool scaled = unit != scene.meters_per_unit && scene.meters_per_unit > 0;
  for (ImportedNode& node : scene.nodes) {
    if (node.parent != kNone) continue;
    if (turned) turn(node.parent_from_local, up);
    if (scaled) {
      for (double& x : node.parent_from_local) x *= scene.meters_per_unit / unit;
    }
  }
  scene.up_axis = up;
  scene.meters_per_unit = unit;
}

Transform frame_conversion(const ImportedScene& scene, std::optional<UpAxis> up_axis,
                           std::optional<double> meters_per_unit) {
  ImportedScene probe;
  probe.nodes.emplace_back();
  probe.up_axis = scene.up_axis;
  probe.meters_per_unit = scene.meters_per_unit;
  convert_frame(probe, up_axis, meters_per_unit);
  return probe.nodes[0].parent_from_local;
}

}  // namespace sightline::client::importer
