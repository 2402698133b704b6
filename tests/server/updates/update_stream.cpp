// A producer of updates, for tests.
#include "tests/server/updates/update_stream.h"

#include <gtest/gtest.h>

#include <limits>

namespace sightline::tests {

UpdateStream::UpdateStream(Api& api) : stream_(api.scenes->StreamUpdates(&context_)) {}

UpdateStream::~UpdateStream() {
  if (finished_) return;
  context_.TryCancel();
  finish();
}

v1::ProducerOpened UpdateStream::open(const std::string& scene, const std::string& producer,
                                      bool latest_wins) {
  v1::StreamUpdatesResponse answer;
  EXPECT_TRUE(send_open(scene, producer, latest_wins));
  const bool answered = read(answer);
  EXPECT_TRUE(answered);
  EXPECT_TRUE(answer.has_opened());
  if (!answered) {
    const grpc::Status status = finish();
    ADD_FAILURE() << status.error_message();
  }
  return answer.opened();
}

bool UpdateStream::send_open(const std::string& scene, const std::string& producer,
                             bool latest_wins) {
  v1::StreamUpdatesRequest request;
  request.mutable_open()->set_scene(scene);
  request.mutable_open()->set_producer(producer);
  request.mutable_open()->set_latest_wins(latest_wins);
  return stream_->Write(request);
}

bool UpdateStream::send(std::uint64_t sequence, const std::vector<v1::Update>& updates, bool more) {
  v1::StreamUpdatesRequest request;
  request.mutable_batch()->set_sequence(sequence);
  request.mutable_batch()->mutable_updates()->Assign(updates.begin(), updates.end());
  request.mutable_batch()->set_more(more);
  return stream_->Write(request);
}

bool UpdateStream::read(v1::StreamUpdatesResponse& answer) { return stream_->Read(&answer); }

std::vector<v1::StreamUpdatesResponse> UpdateStream::read_up_to(std::uint64_t sequence) {
  std::vector<v1::StreamUpdatesResponse> answers;
  v1::StreamUpdatesResponse answer;
  while (read(answer)) {
    answers.push_back(answer);
    if (answer.ack().up_to_sequence() >= sequence || answer.reject().sequence() >= sequence)
      return answers;
  }
  ADD_FAILURE() << "the call ended before batch " << sequence << " was answered";
  answers.emplace_back();
  return answers;
}

grpc::Status UpdateStream::finish() {
  finished_ = true;
  v1::StreamUpdatesResponse answer;
  while (stream_->Read(&answer)) {
  }
  return stream_->Finish();
}

v1::Update move_to(std::uint64_t node, double x) {
  v1::Update update;
  const scenegraph::model::Affine matrix{{1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0}};
  update.mutable_set_transforms()->add_nodes(static_cast<std::int64_t>(node));
  update.mutable_set_transforms()->set_matrices(matrix.m.data(), sizeof(matrix.m));
  return update;
}

v1::Update patch(const std::vector<std::uint64_t>& nodes, std::uint32_t first,
                 const std::vector<accel::geometry::Vec3f>& positions) {
  v1::Update update;
  v1::PatchVertices& vertices = *update.mutable_patch_vertices();
  vertices.mutable_nodes()->Assign(nodes.begin(), nodes.end());
  vertices.set_first(first);
  vertices.set_positions(positions.data(), positions.size() * sizeof(accel::geometry::Vec3f));
  return update;
}

double x_of(Api& api, const std::string& scene, std::uint64_t node) {
  grpc::ClientContext context;
  v1::BatchGetNodesRequest request;
  v1::BatchGetNodesResponse reply;
  request.set_scene(scene);
  request.add_ids(node);
  const grpc::Status status = api.scenes->BatchGetNodes(&context, request, &reply);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return reply.nodes_size() == 1 && reply.nodes(0).id() == node
             ? reply.nodes(0).transform().matrix(3)
             : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace sightline::tests
