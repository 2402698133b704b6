// Scenes by their name on the command line. Files go through the client's importer, as for the
// service.
#include "tests/bench/scenes/load_scene.h"

#include <utility>

#include "client/importer/assimp_import.h"
#include "tests/bench/scenes/generators.h"

namespace sightline::bench {
namespace {

constexpr std::string_view kGenerated = "gen:";

SourceMesh to_source(client::importer::ImportedMesh imported) {
  SourceMesh mesh;
  mesh.vertices.reserve(imported.vertices.size());
  for (const client::Vertex& v : imported.vertices) mesh.vertices.push_back({v[0], v[1], v[2]});
  mesh.faces = std::move(imported.faces);
  return mesh;
}

std::optional<std::size_t> to_index(std::uint32_t index) {
  return index == client::importer::kNone ? std::nullopt : std::optional<std::size_t>(index);
}

Result<SceneSource> import_file(const std::string& file) {
  auto imported = client::importer::import_scene(file);
  if (!imported.ok()) return Error{Code::kNotFound, imported.error().message, "SCENE_FILE"};
  SceneSource scene;
  for (client::importer::ImportedMesh& mesh : imported->meshes) {
    scene.add_mesh(to_source(std::move(mesh)));
  }
  for (client::importer::ImportedNode& node : imported->nodes) {
    scene.add_node(to_index(node.parent), std::move(node.name), {node.parent_from_local},
                   to_index(node.mesh));
  }
  return scene;
}

}  // namespace

Result<SceneSource> load_scene(const std::string& scene) {
  if (scene.starts_with(kGenerated)) {
    return generate(std::string_view(scene).substr(kGenerated.size()), load_scene);
  }
  return import_file(scene);
}

}  // namespace sightline::bench
