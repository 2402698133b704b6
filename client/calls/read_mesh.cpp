// All parts are of one revision. If the server drops that revision meanwhile, the reading begins
// anew.
#include "client/calls/read_mesh.h"

#include <fmt/format.h>

#include <cstring>
#include <optional>

#include "client/calls/connection.h"

namespace sightline::client::calls {
namespace {

constexpr int kAttempts = 3;
constexpr std::size_t kHeaderBytes = 24;

struct Blob {
  std::uint64_t revision = 0;
  std::string bytes;
};

Error broken_blob() { return {Code::kDataLoss, "the server sent what is no mesh", {}}; }

Result<Blob> read_blob(const Connection& connection, const std::string& scene, std::uint64_t node,
                       const std::stop_token& stop) {
  Blob blob;
  v1::ReadMeshRequest request;
  request.set_scene(scene);
  request.set_node(node);
  while (true) {
    request.set_offset(blob.bytes.size());
    grpc::ClientContext context;
    set_timeout(context, connection.small_timeout());
    set_route(context, scene);
    const std::stop_callback cancel(stop, [&] { context.TryCancel(); });
    v1::ReadMeshResponse response;
    const grpc::Status status = connection.scenes->ReadMesh(&context, request, &response);
    if (!status.ok()) return rpc_error(status, stop);
    blob.bytes += response.data();
    blob.revision = response.served().revision();
    request.set_revision(blob.revision);
    if (blob.bytes.size() == response.size()) return blob;
    if (response.data().empty()) return broken_blob();
  }
}

Result<NodeMesh> parse(const Blob& blob) {
  const std::string& bytes = blob.bytes;
  if (bytes.size() < kHeaderBytes || !bytes.starts_with("SLM1")) return broken_blob();
  std::uint64_t vertices = 0, faces = 0;
  std::memcpy(&vertices, &bytes[8], sizeof(vertices));
  std::memcpy(&faces, &bytes[16], sizeof(faces));
  const std::uint64_t rows = (bytes.size() - kHeaderBytes) / sizeof(Vertex);
  if (vertices > rows || faces != rows - vertices) return broken_blob();
  NodeMesh mesh{blob.revision, std::vector<Vertex>(vertices), std::vector<Face>(faces)};
  const char* const positions = bytes.data() + kHeaderBytes;
  // A mesh without vertices or faces has no memory to copy to.
  if (vertices > 0) std::memcpy(mesh.vertices.data(), positions, vertices * sizeof(Vertex));
  if (faces > 0) {
    std::memcpy(mesh.faces.data(), positions + vertices * sizeof(Vertex), faces * sizeof(Face));
  }
  for (const Face& face : mesh.faces) {
    for (const std::uint32_t index : face) {
      if (index != kNoVertex && index >= vertices) return broken_blob();
    }
  }
  return mesh;
}

}  // namespace

Result<NodeMesh> read_mesh(const Connection& connection, const std::string& scene,
                           std::uint64_t node, const std::stop_token& stop) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto blob = read_blob(connection, scene, node, stop);
    if (blob) return parse(*blob);
    if (blob.error().code != Code::kOutOfRange) return blob.error();
  }
  return Error{Code::kAborted,
               fmt::format("node {} of {} changes faster than it can be read", node, scene),
               {}};
}

}  // namespace sightline::client::calls
