// A header, a part of JSON, and a part of arrays.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "client/cli/scene_files/scene_format.h"
#include "client/cli/terminal.h"
#include "client/importer/frame.h"

namespace sightline::client::cli::scene_files {
namespace {

using importer::ImportedMesh;
using importer::ImportedNode;
using importer::ImportedScene;
using Json = nlohmann::json;

constexpr std::uint32_t kMagic = 0x46546c67, kVersion = 2;
constexpr std::uint32_t kJsonPart = 0x4e4f534a, kArraysPart = 0x004e4942;
constexpr int kUnsignedInt = 5125, kFloat = 5126;

// A face without a triangle keeps its place as one of no area.
Face drawn(const Face& face) { return face[0] == kNoVertex ? Face{0, 0, 0} : face; }

bool is_drawn(const ImportedMesh& mesh) { return !mesh.vertices.empty() && !mesh.faces.empty(); }

std::uint64_t bytes_of(const ImportedMesh& mesh) {
  return is_drawn(mesh) ? mesh.vertices.size() * sizeof(Vertex) + mesh.faces.size() * sizeof(Face)
                        : 0;
}

// The column-by-column matrix.
Json matrix_of(const Transform& m) {
  Json matrix = Json::array();
  for (std::size_t column = 0; column < 4; ++column) {
    for (std::size_t row = 0; row < 3; ++row) matrix.push_back(m[4 * row + column]);
    matrix.push_back(column == 3 ? 1 : 0);
  }
  return matrix;
}

class GlbDocument {
 public:
  GlbDocument(const std::vector<ImportedMesh>& meshes, const std::vector<ImportedNode>& nodes) {
    json_["asset"] = {{"version", "2.0"}, {"generator", "sightline"}};
    for (const ImportedMesh& mesh : meshes) add_mesh(mesh);
    if (bytes_ > 0) json_["buffers"] = Json::array({{{"byteLength", bytes_}}});
    add_nodes(nodes);
  }

  std::string text() const {
    std::string text = json_.dump(-1, ' ', false, Json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    return text;
  }

 private:
  void add_mesh(const ImportedMesh& mesh) {
    if (!is_drawn(mesh)) {
      numbers_.emplace_back();
      return;
    }
    const std::size_t positions = json_["accessors"].size();
    add_array(mesh.vertices.size() * sizeof(Vertex), kFloat, mesh.vertices.size(), "VEC3");
    add_bounds(mesh, json_["accessors"].back());
    add_array(mesh.faces.size() * sizeof(Face), kUnsignedInt, 3 * mesh.faces.size(), "SCALAR");
    json_["meshes"].push_back(
        {{"primitives",
          Json::array({{{"attributes", {{"POSITION", positions}}}, {"indices", positions + 1}}})}});
    numbers_.push_back(json_["meshes"].size() - 1);
  }

  void add_array(std::size_t bytes, int type, std::size_t count, const char* shape) {
    json_["accessors"].push_back({{"bufferView", json_["bufferViews"].size()},
                                  {"componentType", type},
                                  {"count", count},
                                  {"type", shape}});
    json_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bytes_}, {"byteLength", bytes}});
    bytes_ += bytes;
  }

  // Adds the bounds of the finite vertices: JSON has no other numbers.
  static void add_bounds(const ImportedMesh& mesh, Json& accessor) {
    for (std::size_t k = 0; k < 3; ++k) {
      float low = std::numeric_limits<float>::max(), high = -low;
      for (const Vertex& vertex : mesh.vertices) {
        if (!std::isfinite(vertex[k])) continue;
        low = std::min(low, vertex[k]);
        high = std::max(high, vertex[k]);
      }
      accessor["min"].push_back(std::min(low, high));
      accessor["max"].push_back(std::max(low, high));
    }
  }

  void add_nodes(const std::vector<ImportedNode>& all) {
    Json nodes = Json::array(), roots = Json::array();
    for (const ImportedNode& node : all) {
      const std::size_t number = nodes.size();
      nodes.push_back({{"name", node.name}, {"matrix", matrix_of(node.parent_from_local)}});
      if (node.mesh != importer::kNone && numbers_[node.mesh])
        nodes.back()["mesh"] = *numbers_[node.mesh];
      Json& siblings = node.parent == importer::kNone ? roots : nodes[node.parent]["children"];
      siblings.push_back(number);
    }
    json_["scene"] = 0;
    json_["scenes"] = Json::array({Json::object()});
    if (nodes.empty()) return;  // lists must not be empty
    json_["scenes"][0]["nodes"] = std::move(roots);
    json_["nodes"] = std::move(nodes);
  }

  Json json_;
  std::uint64_t bytes_ = 0;
  std::vector<std::optional<std::size_t>> numbers_;  // meshes' numbers; none: nothing to draw
};

std::string words(std::initializer_list<std::uint32_t> numbers) {
  std::string bytes;
  for (const std::uint32_t number : numbers)
    bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
  return bytes;
}

template <class Row>
Status send(const std::vector<Row>& rows, const ByteSink& sink) {
  return sink({reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof(Row)});
}

Status send_arrays(const ImportedScene& scene, const ByteSink& sink) {
  for (const ImportedMesh& mesh : scene.meshes) {
    if (!is_drawn(mesh)) continue;
    if (Status sent = send(mesh.vertices, sink); !sent) return sent;
    std::vector<Face> faces(mesh.faces.size());
    std::transform(mesh.faces.begin(), mesh.faces.end(), faces.begin(), drawn);
    if (Status sent = send(faces, sink); !sent) return sent;
  }
  return {};
}

// The scene as glTF wants it: y up and in metres, where both are known.
std::vector<ImportedNode> placed_nodes(const ImportedScene& scene) {
  ImportedScene placed;
  placed.nodes = scene.nodes;
  placed.up_axis = scene.up_axis;
  placed.meters_per_unit = scene.meters_per_unit;
  importer::convert_frame(placed, UpAxis::kY, 1.0);
  return std::move(placed.nodes);
}

}  // namespace

Status write_glb(const ImportedScene& scene, const ByteSink& sink) {
  std::uint64_t arrays = 0;
  for (const ImportedMesh& mesh : scene.meshes) arrays += bytes_of(mesh);
  const std::string json = GlbDocument(scene.meshes, placed_nodes(scene)).text();
  const std::uint64_t total = 12 + 8 + json.size() + (arrays > 0 ? 8 + arrays : 0);
  if (total > std::numeric_limits<std::uint32_t>::max())
    return local_error("more than 4 GiB do not fit .glb: write .obj");
  const auto size = [](std::uint64_t bytes) { return static_cast<std::uint32_t>(bytes); };
  Status sent = sink(words({kMagic, kVersion, size(total), size(json.size()), kJsonPart}) + json);
  if (!sent || arrays == 0) return sent;
  sent = sink(words({size(arrays), kArraysPart}));
  return sent ? send_arrays(scene, sink) : sent;
}

}  // namespace sightline::client::cli::scene_files
