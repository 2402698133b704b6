// Faces keep the file's numbers of vertices until all are known.
#include "client/importer/formats/obj_groups.h"

#include <algorithm>
#include <utility>

namespace sightline::client::importer::formats {
namespace {

constexpr std::string_view kNameless = "defaultobject";

// Gives a part its own vertices. `number` has a number for each vertex of the file, kNone between
// two calls.
FileMesh mesh_of(std::string name, Polygons faces, const std::vector<Point>& vertices,
                 std::vector<std::uint32_t>& number) {
  FileMesh mesh;
  mesh.name = std::move(name);
  std::vector<std::uint32_t> used;
  for (const std::uint32_t vertex : faces.corners) {
    if (number[vertex] != kNone) continue;
    number[vertex] = 0;
    used.push_back(vertex);
  }
  std::sort(used.begin(), used.end());
  mesh.vertices.reserve(used.size());
  for (const std::uint32_t vertex : used) {
    number[vertex] = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(vertices[vertex]);
  }
  for (std::uint32_t& corner : faces.corners) corner = number[corner];
  for (const std::uint32_t vertex : used) number[vertex] = kNone;
  mesh.faces = std::move(faces);
  return mesh;
}

}  // namespace

void ObjGroups::begin_object(std::string_view name) {
  object_ = objects_.size();
  objects_.push_back({std::string(name), {}});
  object_by_name_.emplace(name, object_);
  begin_part(name);
}

void ObjGroups::begin_part(std::string_view name) {
  part_ = parts_.size();
  parts_.push_back({std::string(name), material_, {}});
  objects_[object_].parts.push_back(part_);
}

void ObjGroups::open_object(std::string_view name) {
  if (name.empty()) return;
  const auto known = object_by_name_.find(std::string(name));
  if (known == object_by_name_.end()) {
    begin_object(name);
    return;
  }
  object_ = known->second;
  part_ = objects_[object_].parts.back();
  if (parts_[part_].material != material_ && material_) begin_part(*material_);
}

void ObjGroups::open_group(std::string_view name) {
  if (name == group_) return;
  group_ = name;
  begin_object(name);
}

void ObjGroups::use_material(std::string_view name) {
  if (name.empty() || material_ == name) return;
  material_ = name;
  if (objects_.empty()) return;
  Part& part = parts_[part_];
  if (part.material && part.material != material_ && part.faces.size() > 0) {
    begin_part(name);
  } else {
    part.material = material_;
  }
}

void ObjGroups::add_face(std::span<const std::uint32_t> corners) {
  if (objects_.empty()) begin_object(kNameless);
  Polygons& faces = parts_[part_].faces;
  faces.corners.insert(faces.corners.end(), corners.begin(), corners.end());
  faces.first.push_back(static_cast<std::uint32_t>(faces.corners.size()));
  corner_count_ += corners.size();
}

FileScene ObjGroups::scene(const std::string& name, const std::vector<Point>& vertices) && {
  FileScene scene;
  scene.nodes.push_back({.name = name, .meshes = {}});
  std::vector<std::uint32_t> number(vertices.size(), kNone);
  for (const Object& object : objects_) {
    FileNode node{.name = object.name, .parent = 0, .meshes = {}};
    for (const std::size_t p : object.parts) {
      Part& part = parts_[p];
      if (part.faces.size() == 0) continue;
      node.meshes.push_back(static_cast<std::uint32_t>(scene.meshes.size()));
      scene.meshes.push_back(
          mesh_of(std::move(part.name), std::move(part.faces), vertices, number));
    }
    scene.nodes.push_back(std::move(node));
  }
  if (scene.meshes.empty() && !vertices.empty()) {
    scene.meshes.emplace_back().vertices = vertices;
    scene.nodes[0].meshes = {0};
  }
  return scene;
}

}  // namespace sightline::client::importer::formats
