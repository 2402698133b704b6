// Client calls on a server, for tests.
#pragma once

#include <grpcpp/channel.h>

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "accel/geometry/ray.h"
#include "scenegraph/model/affine.h"
#include "sightline/v1/blob.grpc.pb.h"
#include "sightline/v1/query.grpc.pb.h"
#include "sightline/v1/scene.grpc.pb.h"
#include "sightline/v1/server.grpc.pb.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// The ErrorInfo reason of a status; empty if it has none.
std::string reason_of(const grpc::Status& status);

/// A message with these rays as float64 columns.
v1::Rays encode_rays(std::span<const accel::geometry::Ray> rays);

/// The column of this field; empty if there is none.
std::string column_of(const v1::CastRaysResponse& reply, v1::HitField field);
/// As column_of(), as numbers.
template <class T>
std::vector<T> column_values(const v1::CastRaysResponse& reply, v1::HitField field) {
  const std::string column = column_of(reply, field);
  std::vector<T> values(column.size() / sizeof(T));
  std::copy_n(column.data(), values.size() * sizeof(T), reinterpret_cast<char*>(values.data()));
  return values;
}

/// The rows of a reply that has the fields T, NODE, PRIMITIVE, BARYCENTRIC, NORMAL and HIT.
std::vector<accel::geometry::Hit> decode_hits(const v1::CastRaysResponse& reply);

/// `count` rays along -z from z = 10, over x and y in [0, 1).
std::vector<accel::geometry::Ray> rays_downward(std::size_t count);

class Api {
 public:
  explicit Api(const std::shared_ptr<grpc::Channel>& channel);

  std::unique_ptr<v1::SceneService::Stub> scenes;
  std::unique_ptr<v1::BlobService::Stub> blobs;
  std::unique_ptr<v1::RayQueryService::Stub> rays;
  std::unique_ptr<v1::ServerService::Stub> server;

  grpc::Status create(const std::string& scene);
  grpc::Status remove(const std::string& scene);
  /// Uploads all bytes in chunks of `chunk` bytes.
  grpc::Status upload(const std::string& blob, const std::string& digest,
                      v1::UploadBlobResponse* reply = nullptr, std::size_t chunk = 1 << 20);
  /// Uploads the mesh and returns its digest; fails the test on an error.
  std::string add_mesh(const TestMesh& mesh);
  grpc::Status apply(const std::string& scene, const std::vector<v1::Update>& updates,
                     v1::ApplyUpdatesResponse* reply = nullptr);
  v1::Scene get(const std::string& scene);
  v1::GetSceneStatsResponse stats(const std::string& scene);
  grpc::Status cast(const v1::CastRaysRequest& request, v1::CastRaysResponse* reply);
  grpc::Status cast(const v1::QueryPointsRequest& request, v1::QueryPointsResponse* reply);
  /// The reply; fails the test on an error.
  v1::CastRaysResponse cast(const v1::CastRaysRequest& request);

  /// Creates a scene of one node with this mesh; fails the test on an error.
  void make_scene(const std::string& scene, const TestMesh& mesh);
};

/// A PutNode of a new node.
v1::Update put_node(std::int64_t alias, const std::string& digest = {}, std::int64_t parent = 0,
                    const scenegraph::model::Affine& parent_from_local = {});

/// A request for closest hits with the default fields.
v1::CastRaysRequest cast_request(const std::string& scene,
                                 std::span<const accel::geometry::Ray> rays);

}  // namespace sightline::tests
