// Sends the nodes of a scene in messages of one call.
#include "client/calls/put_scene.h"

#include <cstddef>
#include <utility>

#include "client/calls/apply.h"
#include "client/calls/connection.h"
#include "client/calls/retries.h"
#include "client/wire/scene_codec.h"

namespace sightline::client::calls {
namespace {

// Fills messages with nodes and sends those that are full.
class NodeWriter {
 public:
  NodeWriter(grpc::ClientWriter<v1::PutSceneRequest>& writer, v1::PutSceneRequest first)
      : writer_(writer), message_(std::move(first)) {}

  // Returns false if the server has ended the call.
  bool add(const PutNode& node) {
    v1::PutNode encoded = std::move(*wire::encode(Update(node)).mutable_put_node());
    const std::size_t bytes = encoded.ByteSizeLong() + 8;  // with its tag and length
    const bool full = bytes_ > 0 && bytes_ + bytes > wire::kMaxUpdateBytes;
    if (full || static_cast<std::size_t>(message_.nodes_size()) == kMaxUpdatesPerBatch) {
      if (!writer_.Write(message_)) return false;
      message_.Clear();
      bytes_ = 0;
    }
    bytes_ += bytes;
    *message_.add_nodes() = std::move(encoded);
    return true;
  }

  void finish() {
    message_.set_finish(true);
    if (writer_.Write(message_)) writer_.WritesDone();
  }

 private:
  grpc::ClientWriter<v1::PutSceneRequest>& writer_;
  v1::PutSceneRequest message_;
  std::size_t bytes_ = 0;
};

/// A call that is refused has made nothing.
grpc::Status put_once(const Connection& connection, const std::string& scene,
                      std::span<const PutNode> nodes, const PutSceneOptions& options,
                      v1::PutSceneResponse& response) {
  connection.wait_until_connected();
  grpc::ClientContext context;
  set_timeout(context, connection.timeout);
  set_route(context, scene);
  const std::stop_callback cancel(options.stop, [&] { context.TryCancel(); });
  const auto stream = connection.scenes->PutScene(&context, &response);
  v1::PutSceneRequest first;
  first.mutable_scene()->set_name(scene);
  first.mutable_scene()->set_up_axis(wire::encode(options.up_axis));
  first.mutable_scene()->set_meters_per_unit(options.meters_per_unit);
  first.set_replace(options.replace);
  NodeWriter writer(*stream, std::move(first));
  bool open = true;
  for (std::size_t i = 0; i < nodes.size() && open; ++i) open = writer.add(nodes[i]);
  if (open) writer.finish();
  return stream->Finish();
}

}  // namespace

Result<SceneInfo> put_scene(const Connection& connection, const std::string& scene,
                            std::span<const PutNode> nodes, const PutSceneOptions& options) {
  Retries retries;
  while (true) {
    v1::PutSceneResponse response;
    const grpc::Status status = put_once(connection, scene, nodes, options, response);
    if (status.ok()) return wire::decode(response.scene());
    if (!retries.wait(status, options.stop)) return rpc_error(status, options.stop);
  }
}

}  // namespace sightline::client::calls
