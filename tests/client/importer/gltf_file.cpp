// Has one buffer, embedded as base64.
#include "tests/client/importer/gltf_file.h"

#include <cmath>
#include <map>

namespace sightline::tests {
namespace {

using nlohmann::json;

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8U | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return out;
}

std::string little_endian(std::size_t value) {
  std::string out;
  for (unsigned i = 0; i < 4; ++i) out += static_cast<char>(value >> (8 * i) & 0xFFU);
  return out;
}

}  // namespace

GltfFile::GltfFile()
    : json{{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}} {}

std::size_t GltfFile::width_of(const std::string& type) {
  return std::map<std::string, std::size_t>{
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}}
      .at(type);
}

int GltfFile::add_view(std::string_view bytes) {
  json["bufferViews"].push_back(
      {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}});
  bytes_ += bytes;
  bytes_.resize((bytes_.size() + 3) / 4 * 4);
  return static_cast<int>(json["bufferViews"].size()) - 1;
}

int GltfFile::add_bytes(std::string_view bytes, int component, std::size_t rows,
                        const std::string& type) {
  json["accessors"].push_back({{"bufferView", add_view(bytes)},
                               {"componentType", component},
                               {"count", rows},
                               {"type", type}});
  return static_cast<int>(json["accessors"].size()) - 1;
}

void GltfFile::animate(int node, const std::string& path, const std::vector<float>& seconds,
                       const std::vector<float>& values) {
  const std::string type = path == "rotation" ? "VEC4" : path == "weights" ? "SCALAR" : "VEC3";
  nlohmann::json& animation = json["animations"][0];
  const std::size_t sampler = animation["samplers"].size();
  const int times = add(seconds, "SCALAR");
  animation["samplers"].push_back({{"input", times}, {"output", add(values, type)}});
  animation["channels"].push_back(
      {{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}});
}

std::string GltfFile::text() const {
  nlohmann::json whole = json;
  whole["buffers"] = {{{"byteLength", bytes_.size()},
                       {"uri", "data:application/octet-stream;base64," + base64(bytes_)}}};
  return whole.dump();
}

std::string GltfFile::glb() const {
  nlohmann::json whole = json;
  whole["buffers"] = {{{"byteLength", bytes_.size()}}};
  std::string text = whole.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  return "glTF" + little_endian(2) + little_endian(28 + text.size() + bytes_.size()) +
         little_endian(text.size()) + "JSON" + text + little_endian(bytes_.size()) +
         std::string("BIN\0", 4) + bytes_;
}

GltfFile triangle_under_root() {
  GltfFile file;
  const int positions = file.add({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  file.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}}}}}}}};
  file.json["nodes"] = {{{"name", "root"}, {"children", {1}}}, {{"name", "blade"}, {"mesh", 0}}};
  return file;
}

GltfFile bending_strip() {
  GltfFile file;
  const int positions =
      file.add({-0.5F, 0, 0, 0.5F, 0, 0, -0.5F, 1, 0, 0.5F, 1, 0, -0.5F, 2, 0, 0.5F, 2, 0}, "VEC3");
  const int indices =
      file.add_shorts(std::vector<std::uint16_t>{0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4}, "SCALAR");
  const int joints = file.add_shorts(std::vector<std::uint16_t>{0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0,
                                                                0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0},
                                     "VEC4");
  const int weights = file.add(
      {1, 0, 0, 0, 1, 0, 0, 0, 0.5F, 0.5F, 0, 0, 0.5F, 0.5F, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, "VEC4");
  // Columns: no offset at the foot, one down at the upper joint.
  const int inverses = file.add({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,
                                 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1},
                                "MAT4");
  file.json["meshes"] = {
      {{"primitives",
        {{{"attributes", {{"POSITION", positions}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}}},
          {"indices", indices}}}}}};
  file.json["skins"] = {{{"joints", {2, 3}}, {"inverseBindMatrices", inverses}}};
  file.json["nodes"] = {{{"name", "root"}, {"children", {1, 2}}},
                        {{"name", "strip"}, {"mesh", 0}, {"skin", 0}, {"translation", {10, 0, 0}}},
                        {{"name", "foot"}, {"children", {3}}},
                        {{"name", "knee"}, {"translation", {0, 1, 0}}}};
  const float half = std::sqrt(0.5F);
  file.animate(3, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, half, half});
  return file;
}

}  // namespace sightline::tests
