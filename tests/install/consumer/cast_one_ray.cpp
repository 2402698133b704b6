// Makes a scene of one square, casts a ray at it, and removes it: consumer ENDPOINT.
#include <sightline/client/async_client.h>
#include <sightline/client/client.h>
#include <sightline/client/importer/imported_scene.h>
#include <sightline/client/scene_upload.h>

#include <cstdint>
#include <cstdio>
#include <vector>

namespace client = sightline::client;

namespace {

constexpr const char* kScene = "projects/default/scenes/consumer";

template <class T>
bool succeeded(const client::Result<T>& result) {
  if (!result) std::fprintf(stderr, "%s\n", result.error().message.c_str());
  return result.ok();
}

client::importer::ImportedScene square() {
  client::importer::ImportedMesh mesh;
  mesh.name = "square";
  mesh.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  mesh.triangles = 2;
  client::importer::ImportedScene scene;
  scene.meshes = {mesh};
  scene.nodes.push_back({.name = "square", .mesh = 0});
  return scene;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fputs("consumer ENDPOINT\n", stderr), 2;
  const auto server = client::Client::connect(argv[1]);
  if (!succeeded(server)) return 1;
  if (!succeeded(client::upload_scene(*server, kScene, square(), {.replace = true}))) return 1;

  const std::vector<double> origins{0.25, 0.5, 3}, directions{0, 0, -2};
  std::vector<double> t(1);
  std::vector<std::uint32_t> primitive(1);
  const client::RayColumns<const double> rays{.origins = origins, .directions = directions};
  const client::HitColumns hits{.t = t, .primitive = primitive};
  const client::AsyncClient async(*server);
  if (!succeeded(async.cast(kScene, rays, hits).future().get())) return 1;
  const auto report = server->cast(kScene, rays, hits);
  if (!succeeded(report) || !succeeded(server->delete_scene(kScene))) return 1;

  std::printf("%d hit, t %g, primitive %d\n", static_cast<int>(report->hits), t[0],
              static_cast<int>(primitive[0]));
}
