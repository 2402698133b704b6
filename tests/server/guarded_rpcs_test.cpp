// Every method of every service refuses calls that it should refuse.
#include "server/guarded_rpcs.h"

#include <google/protobuf/descriptor.h>
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "sightline/v1/backup.pb.h"
#include "tests/server/support/raw_call.h"
#include "tests/server/support/secured_server.h"

namespace sightline::tests {
namespace {

class GuardedRpcs : public SecuredServer {
 protected:
  static std::vector<std::string> methods() {
    std::vector<std::string> paths;
    for (const auto* file :
         {v1::CastRaysRequest::descriptor()->file(), v1::Scene::descriptor()->file(),
          v1::UploadBlobRequest::descriptor()->file(), v1::BackupRequest::descriptor()->file(),
          v1::GetServerInfoRequest::descriptor()->file()}) {
      for (int s = 0; s < file->service_count(); ++s) {
        for (int m = 0; m < file->service(s)->method_count(); ++m) {
          paths.push_back("/" + file->service(s)->full_name() + "/" +
                          file->service(s)->method(m)->name());
        }
      }
    }
    return paths;
  }

  grpc::Status remove(const std::string& token) {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + token);
    v1::DeleteSceneRequest request;
    request.set_name(kOwnScene);
    v1::DeleteSceneResponse reply;
    return v1::SceneService::NewStub(channel_)->DeleteScene(&context, request, &reply);
  }

  grpc::Status create(const std::string& token, const std::string& scene) {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + token);
    v1::CreateSceneRequest request;
    request.mutable_scene()->set_name(scene);
    v1::CreateSceneResponse reply;
    return v1::SceneService::NewStub(channel_)->CreateScene(&context, request, &reply);
  }

  std::vector<std::string> list(const std::string& token, const std::string& project) {
    grpc::ClientContext context;
    context.AddMetadata("authorization", "Bearer " + token);
    v1::ListScenesRequest request;
    request.set_parent(project);
    v1::ListScenesResponse reply;
    EXPECT_TRUE(v1::SceneService::NewStub(channel_)->ListScenes(&context, request, &reply).ok());
    std::vector<std::string> names;
    for (const v1::Scene& scene : reply.scenes()) names.push_back(scene.name());
    return names;
  }

  const std::shared_ptr<grpc::Channel> channel_ = connect();
};

TEST_F(GuardedRpcs, NoMethodAnswersWithoutAToken) {
  const auto paths = methods();
  EXPECT_GE(paths.size(), 18u);
  for (const std::string& path : paths) {
    const grpc::Status none = call_raw(channel_, path, {});
    EXPECT_EQ(none.error_code(), grpc::StatusCode::UNAUTHENTICATED) << path;
    EXPECT_EQ(reason_of(none), "TOKEN_MISSING") << path;
    const grpc::Status unknown = call_raw(channel_, path, {}, "unknown-token");
    EXPECT_EQ(unknown.error_code(), grpc::StatusCode::UNAUTHENTICATED) << path;
    EXPECT_EQ(reason_of(unknown), "TOKEN_UNKNOWN") << path;
  }
}

TEST_F(GuardedRpcs, AMethodThatChangesSomethingRefusesAReader) {
  int refused = 0;
  for (const std::string& path : methods()) {
    if (reason_of(call_raw(channel_, path, {}, kReader)) == "ROLE_MISSING") ++refused;
  }
  EXPECT_EQ(refused, 12)
      << "CreateScene PutScene DeleteScene ApplyUpdates StreamUpdates CoolScene, of meshes 3, "
         "Backup Restore ReadLog";
}

TEST_F(GuardedRpcs, OnlyAnAdministratorDeletes) {
  ASSERT_TRUE(create(kWriter, kOwnScene).ok());
  EXPECT_EQ(reason_of(remove(kWriter)), "ROLE_MISSING");
  EXPECT_EQ(reason_of(remove(kStranger)), "SCENE_FORBIDDEN");
  EXPECT_TRUE(remove(kAdministrator).ok());
}

TEST_F(GuardedRpcs, OnlyAnAdministratorReplaces) {
  const std::string path = "/sightline.v1.SceneService/PutScene";
  v1::PutSceneRequest put;
  put.mutable_scene()->set_name(kOwnScene);
  put.set_finish(true);
  EXPECT_EQ(reason_of(call_raw(channel_, path, put.SerializeAsString(), kStranger)),
            "SCENE_FORBIDDEN");
  EXPECT_TRUE(call_raw(channel_, path, put.SerializeAsString(), kWriter).ok());
  put.set_replace(true);
  EXPECT_EQ(reason_of(call_raw(channel_, path, put.SerializeAsString(), kWriter)), "ROLE_MISSING");
  EXPECT_TRUE(call_raw(channel_, path, put.SerializeAsString(), kAdministrator).ok());
}

TEST_F(GuardedRpcs, OnlyAWriterCastsWithUpdates) {
  ASSERT_TRUE(create(kWriter, kOwnScene).ok());
  v1::CastRaysRequest rays;
  v1::QueryPointsRequest points;
  rays.set_scene(kOwnScene);
  points.set_scene(kOwnScene);
  const auto call = [&](const char* method, const std::string& request, const std::string& token) {
    return call_raw(channel_, std::string("/sightline.v1.RayQueryService/") + method, request,
                    token);
  };
  EXPECT_TRUE(call("CastRays", rays.SerializeAsString(), kReader).ok());
  EXPECT_TRUE(call("QueryPoints", points.SerializeAsString(), kReader).ok());
  rays.mutable_apply();
  points.mutable_apply();
  for (const auto& [method, request] : {std::pair("CastRays", rays.SerializeAsString()),
                                        std::pair("QueryPoints", points.SerializeAsString())}) {
    const grpc::Status refused = call(method, request, kReader);
    EXPECT_EQ(refused.error_code(), grpc::StatusCode::PERMISSION_DENIED) << method;
    EXPECT_EQ(reason_of(refused), "ROLE_MISSING") << method;
    EXPECT_EQ(reason_of(call(method, request, kStranger)), "SCENE_FORBIDDEN") << method;
    const grpc::Status done = call(method, request, kWriter);
    EXPECT_TRUE(done.ok()) << method << ": " << done.error_message();
  }
}

TEST_F(GuardedRpcs, AListShowsWhatMayBeRead) {
  ASSERT_TRUE(create(kWriter, kOwnScene).ok());
  EXPECT_EQ(list(kReader, "projects/site"), std::vector{kOwnScene});
  EXPECT_TRUE(list(kStranger, "projects/site").empty());
  EXPECT_EQ(list(kReader, "projects/-"), std::vector{kOwnScene});
  EXPECT_TRUE(list(kStranger, "projects/-").empty());
}

TEST_F(GuardedRpcs, TheSceneOfAStreamIsCheckedToo) {
  v1::StreamCastRaysRequest cast;
  cast.mutable_request()->set_scene(kOwnScene);
  EXPECT_EQ(reason_of(call_raw(channel_, "/sightline.v1.RayQueryService/StreamCastRays",
                               cast.SerializeAsString(), kStranger)),
            "SCENE_FORBIDDEN");
  v1::StreamUpdatesRequest update;
  update.mutable_open()->set_scene(kOwnScene);
  update.mutable_open()->set_producer("p");
  EXPECT_EQ(reason_of(call_raw(channel_, "/sightline.v1.SceneService/StreamUpdates",
                               update.SerializeAsString(), kStranger)),
            "SCENE_FORBIDDEN");
}

}  // namespace
}  // namespace sightline::tests
