// One mesh for each primitive, skin and set of weights.
#include "client/importer/gltf/meshes.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "client/importer/gltf/nodes.h"
#include "client/importer/gltf/primitive.h"

namespace sightline::client::importer::gltf {
namespace {

std::size_t shapes_of(const Item& mesh) {
  std::size_t shapes = 0;
  bool is_first = true;
  for (const Item& primitive : mesh.objects("primitives")) {
    const std::size_t here = primitive.objects("targets").size();
    if (!is_first && here != shapes)
      refuse("{}: its primitives have {} and {} targets", mesh.where(), shapes, here);
    shapes = here;
    is_first = false;
  }
  return shapes;
}

std::vector<double> weights_of(const Item& node, const Item& mesh) {
  const std::size_t shapes = shapes_of(mesh);
  if (shapes == 0) return {};
  const Item& owner = node.has("weights") ? node : mesh;
  std::vector<double> weights = owner.numbers("weights");
  if (owner.has("weights") && weights.size() != shapes) {
    refuse("{}: weights has {} numbers, but there are {} targets", owner.where(), weights.size(),
           shapes);
  }
  weights.resize(shapes);
  return weights;
}

Transform bone_of(const std::array<double, 16>& inverse_bind, const std::string& where) {
  for (const double x : inverse_bind) {
    if (!std::isfinite(x)) refuse("{}: an inverse bind matrix holds {}", where, x);
  }
  return affine_of(inverse_bind, where + ": the last row of an inverse bind matrix");
}

}  // namespace

const std::vector<std::uint32_t>& Meshes::of(const Item& node) {
  const Item mesh = document_.at("meshes", node.integer("mesh"), node.where());
  Use use{node.integer("mesh"), node.find_integer("skin"), weights_of(node, mesh)};
  const auto known = known_.find(use);
  if (known != known_.end()) return known->second;
  std::vector<std::uint32_t> meshes = read(mesh, use);
  return known_[std::move(use)] = std::move(meshes);
}

std::size_t Meshes::shapes(const Item& node) const {
  if (!node.has("mesh")) return 0;
  return shapes_of(document_.at("meshes", node.integer("mesh"), node.where()));
}

std::vector<std::uint32_t> Meshes::read(const Item& mesh, const Use& use) {
  std::string name = mesh.text("name");
  if (name.empty()) name = fmt::format("meshes[{}]", std::get<0>(use));
  const std::vector<Item> primitives = mesh.objects("primitives");
  if (primitives.empty()) warn("no_primitives", mesh, "has no primitives, so that it is empty");
  std::vector<std::uint32_t> out;
  for (std::size_t p = 0; p < primitives.size(); ++p) {
    FileMesh read = read_primitive(primitives[p], use);
    read.name = primitives.size() > 1 ? fmt::format("{}-{}", name, p) : name;
    out.push_back(static_cast<std::uint32_t>(scene_.meshes.size()));
    scene_.meshes.push_back(std::move(read));
  }
  return out;
}

FileMesh Meshes::read_primitive(const Item& item, const Use& use) {
  const auto& [mesh, skin, weights] = use;
  FileMesh out;
  Primitive primitive(item, document_, buffers_, accessors_);
  if (!primitive.has_positions()) {
    warn("no_positions", item, "has no POSITION, so that it is empty");
    return out;
  }
  out.vertices = primitive.vertices();
  const std::size_t vertices = out.vertices.size();
  const std::vector<std::uint32_t> indices = primitive.indices(vertices);
  if (left_over(primitive.mode(), indices.size()) > 0)
    warn("left_over_indices", item, "has indices at its end that form no whole face");
  out.faces = faces_of(primitive.mode(), indices);
  out.shapes = primitive.shapes(vertices);
  out.weights = weights;
  if (!skin) return out;
  if (primitive.has_joints()) {
    out.skin = primitive.skin(bones(*skin, item.where()), vertices);
  } else {
    warn("no_joints", item, "has no JOINTS_0, though its node has a skin: it stays with the node");
  }
  return out;
}

std::vector<Skin::Bone> Meshes::bones(std::uint64_t skin, const std::string& by) {
  const Item item = document_.at("skins", skin, by);
  const std::vector<std::uint64_t> joints = item.integers("joints");
  std::vector<std::array<double, 16>> inverses;
  if (item.has("inverseBindMatrices")) {
    inverses = accessors_.rows<16>(item.integer("inverseBindMatrices"), item.where());
    if (inverses.size() < joints.size()) {
      refuse("{}: it has {} inverse bind matrices for {} joints", item.where(), inverses.size(),
             joints.size());
    }
  }
  std::vector<Skin::Bone> out;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    document_.at("nodes", joints[j], item.where());
    const std::uint32_t node = from_gltf_[joints[j]];
    if (node == kNone)
      refuse("{}: its joint nodes[{}] is not in the scene", item.where(), joints[j]);
    out.push_back({node, inverses.empty() ? kIdentity : bone_of(inverses[j], item.where())});
  }
  return out;
}

void Meshes::warn(const char* kind, const Item& where, const char* message) {
  const auto known = std::find_if(scene_.warnings.begin(), scene_.warnings.end(),
                                  [&](const Warning& warning) { return warning.kind == kind; });
  if (known != scene_.warnings.end()) {
    ++known->count;
    return;
  }
  scene_.warnings.push_back({.kind = kind,
                             .first = where.where(),
                             .message = fmt::format("{} {}", where.where(), message)});
}

}  // namespace sightline::client::importer::gltf
