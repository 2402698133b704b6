// From the container to nodes, meshes and animations.
#include "client/importer/gltf/read_gltf.h"

#include <cstddef>
#include <cstdint>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "client/importer/gltf/accessors.h"
#include "client/importer/gltf/animations.h"
#include "client/importer/gltf/buffers.h"
#include "client/importer/gltf/container.h"
#include "client/importer/gltf/document.h"
#include "client/importer/gltf/extensions.h"
#include "client/importer/gltf/meshes.h"
#include "client/importer/gltf/nodes.h"

namespace sightline::client::importer::gltf {
namespace {

FileScene read(const SceneFile& file) {
  const Container container = open_container(file.bytes);
  const Document document(container.json);
  FileScene scene;
  scene.up_axis = UpAxis::kY;
  scene.meters_per_unit = 1;
  for (const std::string& extension : check_extensions(document)) {
    scene.warnings.push_back(
        {.kind = "gltf_extension",
         .first = extension,
         .message = fmt::format("it uses the glTF extension {}, which is not read: what it changes "
                                "is missing",
                                extension)});
  }
  Buffers buffers(document, container, file.files);
  Accessors accessors(document, buffers);
  Nodes nodes = read_nodes(document, accessors, scene.warnings);
  scene.nodes = std::move(nodes.nodes);
  Meshes meshes(document, buffers, accessors, nodes.from_gltf, scene);
  for (std::size_t i = 0; i < nodes.mesh_nodes.size(); ++i) {
    const auto [gltf, first, count] = nodes.mesh_nodes[i];
    const std::vector<std::uint32_t>& node_meshes =
        meshes.of(document.at("nodes", gltf, "the file"));
    for (std::uint32_t node = first; node < first + count; ++node)
      scene.nodes[node].meshes = node_meshes;
    if (file.progress)
      file.progress(static_cast<double>(i + 1) / static_cast<double>(nodes.mesh_nodes.size()));
  }
  read_animations(document, accessors, meshes, nodes, scene);
  return scene;
}

}  // namespace

Result<FileScene> read_gltf(const SceneFile& file) {
  try {
    return read(file);
  } catch (const Refusal& refusal) {
    return import_error(refusal.what());
  } catch (const std::bad_alloc&) {
    return import_error("what it describes needs more memory than a file of this size may use");
  }
}

}  // namespace sightline::client::importer::gltf
