// Client calls on a server, for tests.
#include "tests/server/support/api.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "tests/server/blobs/blob_of.h"

namespace sightline::tests {
namespace {

template <class T>
void append(std::string& column, const T& value) {
  column.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <class T>
T row(const std::string& column, std::size_t index) {
  T value;
  std::memcpy(&value, column.data() + index * sizeof(T), sizeof(T));
  return value;
}

}  // namespace

std::string reason_of(const grpc::Status& status) {
  google::rpc::Status details;
  google::rpc::ErrorInfo info;
  if (!details.ParseFromString(status.error_details()) || details.details_size() == 0) return {};
  return details.details(0).UnpackTo(&info) ? info.reason() : std::string();
}

v1::Rays encode_rays(std::span<const accel::geometry::Ray> rays) {
  v1::Rays columns;
  columns.set_float64(true);
  for (const accel::geometry::Ray& ray : rays) {
    append(*columns.mutable_origins(), ray.origin);
    append(*columns.mutable_directions(), ray.direction);
    append(*columns.mutable_tmin(), ray.tmin);
    append(*columns.mutable_tmax(), ray.tmax);
    append(*columns.mutable_masks(), ray.mask);
  }
  return columns;
}

std::string column_of(const v1::CastRaysResponse& reply, v1::HitField field) {
  for (const v1::HitColumn& column : reply.columns()) {
    if (column.field() == field) return column.data();
  }
  return {};
}

std::vector<accel::geometry::Hit> decode_hits(const v1::CastRaysResponse& reply) {
  const std::string state = column_of(reply, v1::HIT_FIELD_HIT);
  const std::string t = column_of(reply, v1::HIT_FIELD_T);
  const std::string node = column_of(reply, v1::HIT_FIELD_NODE);
  const std::string primitive = column_of(reply, v1::HIT_FIELD_PRIMITIVE);
  const std::string barycentric = column_of(reply, v1::HIT_FIELD_BARYCENTRIC);
  const std::string normal = column_of(reply, v1::HIT_FIELD_NORMAL);
  std::vector<accel::geometry::Hit> hits(state.size());
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const auto uv = row<std::array<float, 2>>(barycentric, i);
    hits[i].state = static_cast<accel::geometry::HitState>(state[i]);
    hits[i].t = row<double>(t, i);
    hits[i].node = row<std::uint64_t>(node, i);
    hits[i].primitive = row<std::uint32_t>(primitive, i);
    hits[i].u = uv[0];
    hits[i].v = uv[1];
    hits[i].normal = row<accel::geometry::Vec3f>(normal, i);
  }
  return hits;
}

std::vector<accel::geometry::Ray> rays_downward(std::size_t count) {
  std::vector<accel::geometry::Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto k = static_cast<double>(i);
    rays[i].origin = {std::fmod(k * 0.618034, 1.0), std::fmod(k * 0.754878, 1.0), 10};
    rays[i].direction = {0, 0, -1};
  }
  return rays;
}

Api::Api(const std::shared_ptr<grpc::Channel>& channel)
    : scenes(v1::SceneService::NewStub(channel)),
      blobs(v1::BlobService::NewStub(channel)),
      rays(v1::RayQueryService::NewStub(channel)),
      server(v1::ServerService::NewStub(channel)) {}

grpc::Status Api::create(const std::string& scene) {
  grpc::ClientContext context;
  v1::CreateSceneRequest request;
  v1::CreateSceneResponse reply;
  request.mutable_scene()->set_name(scene);
  return scenes->CreateScene(&context, request, &reply);
}

grpc::Status Api::remove(const std::string& scene) {
  grpc::ClientContext context;
  v1::DeleteSceneRequest request;
  v1::DeleteSceneResponse reply;
  request.set_name(scene);
  return scenes->DeleteScene(&context, request, &reply);
}

grpc::Status Api::upload(const std::string& blob, const std::string& digest,
                         v1::UploadBlobResponse* reply, std::size_t chunk_size) {
  grpc::ClientContext context;
  v1::UploadBlobResponse ignored;
  const auto writer = blobs->UploadBlob(&context, reply != nullptr ? reply : &ignored);
  v1::UploadBlobRequest chunk;
  chunk.set_digest(digest);
  for (std::size_t at = 0; !chunk.finish(); at += chunk_size) {
    chunk.set_offset(at);
    chunk.set_data(blob.substr(at, chunk_size));
    chunk.set_finish(at + chunk_size >= blob.size());
    if (!writer->Write(chunk)) break;
    chunk.clear_digest();
  }
  writer->WritesDone();
  return writer->Finish();
}

std::string Api::add_mesh(const TestMesh& mesh) {
  const std::string blob = blob_of(mesh);
  const std::string digest = digest_of(blob).text();
  const grpc::Status status = upload(blob, digest);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return digest;
}

grpc::Status Api::apply(const std::string& scene, const std::vector<v1::Update>& updates,
                        v1::ApplyUpdatesResponse* reply) {
  grpc::ClientContext context;
  v1::ApplyUpdatesRequest request;
  v1::ApplyUpdatesResponse ignored;
  request.set_scene(scene);
  request.mutable_updates()->Assign(updates.begin(), updates.end());
  return scenes->ApplyUpdates(&context, request, reply != nullptr ? reply : &ignored);
}

v1::Scene Api::get(const std::string& scene) {
  grpc::ClientContext context;
  v1::GetSceneRequest request;
  v1::GetSceneResponse reply;
  request.set_name(scene);
  const grpc::Status status = scenes->GetScene(&context, request, &reply);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return reply.scene();
}

v1::GetSceneStatsResponse Api::stats(const std::string& scene) {
  grpc::ClientContext context;
  v1::GetSceneStatsRequest request;
  v1::GetSceneStatsResponse reply;
  request.set_scene(scene);
  const grpc::Status status = scenes->GetSceneStats(&context, request, &reply);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return reply;
}

grpc::Status Api::cast(const v1::CastRaysRequest& request, v1::CastRaysResponse* reply) {
  grpc::ClientContext context;
  return rays->CastRays(&context, request, reply);
}

grpc::Status Api::cast(const v1::QueryPointsRequest& request, v1::QueryPointsResponse* reply) {
  grpc::ClientContext context;
  return rays->QueryPoints(&context, request, reply);
}

v1::CastRaysResponse Api::cast(const v1::CastRaysRequest& request) {
  v1::CastRaysResponse reply;
  const grpc::Status status = cast(request, &reply);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return reply;
}

void Api::make_scene(const std::string& scene, const TestMesh& mesh) {
  const grpc::Status created = create(scene);
  EXPECT_TRUE(created.ok()) << created.error_message();
  const grpc::Status applied = apply(scene, {put_node(-1, add_mesh(mesh))});
  EXPECT_TRUE(applied.ok()) << applied.error_message();
}

v1::Update put_node(std::int64_t alias, const std::string& digest, std::int64_t parent,
                    const scenegraph::model::Affine& parent_from_local) {
  v1::Update update;
  v1::PutNode& put = *update.mutable_put_node();
  put.set_node(alias);
  put.set_parent(parent);
  put.set_mesh_digest(digest);
  put.mutable_transform()->mutable_matrix()->Assign(parent_from_local.m.begin(),
                                                    parent_from_local.m.end());
  return update;
}

v1::CastRaysRequest cast_request(const std::string& scene,
                                 std::span<const accel::geometry::Ray> rays) {
  v1::CastRaysRequest request;
  request.set_scene(scene);
  *request.mutable_rays() = encode_rays(rays);
  return request;
}

}  // namespace sightline::tests
