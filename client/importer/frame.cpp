// Reads the frame of a file, and turns a scene into another frame.
#include "client/importer/frame.h"

#include <assimp/scene.h>

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

void set_row(std::array<double, 12>& m, std::size_t to, const std::array<double, 12>& from,
             std::size_t row, double factor) {
  for (std::size_t k = 0; k < 4; ++k) m[to * 4 + k] = factor * from[row * 4 + k];
}

// From y up to z up: (x, y, z) -> (x, -z, y). From z up to y up: (x, y, z) -> (x, z, -y).
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
  if (is("glTF") || is("Collada") || is("IFC")) return {UpAxis::kY, 1.0};
  if (is("FBX")) return frame_of_fbx(scene);
  return {};
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
