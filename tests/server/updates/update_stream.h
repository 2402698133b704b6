// A producer of updates, for tests.
#pragma once

#include <grpcpp/client_context.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/support/api.h"

namespace sightline::tests {

class UpdateStream {
 public:
  /// Does not open the stream.
  explicit UpdateStream(Api& api);
  ~UpdateStream();

  /// Opens the stream and reads the reply; fails the test if it is no `opened`.
  v1::ProducerOpened open(const std::string& scene, const std::string& producer = "robot",
                          bool latest_wins = false);
  /// False after the call has ended.
  bool send_open(const std::string& scene, const std::string& producer, bool latest_wins = false);
  bool send(std::uint64_t sequence, const std::vector<v1::Update>& updates, bool more = false);
  bool read(v1::StreamUpdatesResponse& answer);
  /// Reads until an ack or reject covers this batch; returns the answers read, at least one. Fails
  /// the test if the call ends before.
  std::vector<v1::StreamUpdatesResponse> read_up_to(std::uint64_t sequence);

  /// Closes the client's side.
  void close() { stream_->WritesDone(); }
  void cancel() { context_.TryCancel(); }
  /// Reads the rest and ends the call.
  grpc::Status finish();

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>>
      stream_;
  bool finished_ = false;
};

/// A SetTransforms that moves one node along x.
v1::Update move_to(std::uint64_t node, double x);

/// A PatchVertices of these nodes.
v1::Update patch(const std::vector<std::uint64_t>& nodes, std::uint32_t first,
                 const std::vector<accel::geometry::Vec3f>& positions);

/// The node's translation along x, or NaN if there is no such node.
double x_of(Api& api, const std::string& scene, std::uint64_t node);

}  // namespace sightline::tests
