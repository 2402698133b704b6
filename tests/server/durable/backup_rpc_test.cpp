// What a backup call takes of its client.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/exec/rpc_status.h"
#include "sightline/v1/backup.grpc.pb.h"
#include "tests/server/support/live_server.h"

namespace sightline::tests {
namespace {

using BackupRpc = LiveServer;

TEST_F(BackupRpc, KnownMeshesAreDigestsAndNotTooMany) {
  const auto status_of = [this](const std::vector<std::string>& known) {
    v1::BackupRequest request;
    for (const std::string& digest : known) request.add_known_meshes(digest);
    grpc::ClientContext context;
    const auto stub = v1::BackupService::NewStub(channel_);
    const auto call = stub->Backup(&context, request);
    v1::BackupResponse response;
    EXPECT_FALSE(call->Read(&response));
    return call->Finish();
  };
  const std::string digest = "sha256:" + std::string(64, 'a') + "/7";
  EXPECT_EQ(server::exec::reason_of(status_of(std::vector(8192, digest))), "NOT_DURABLE");
  const grpc::Status many = status_of(std::vector(8193, digest));
  EXPECT_EQ(many.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_NE(many.error_message().find("8193 known meshes in a request, at most 8192"),
            std::string::npos)
      << many.error_message();
  for (const std::string wrong : {"", "sha256:aa/7", "meshes/aa"})
    EXPECT_EQ(status_of({digest, wrong}).error_code(), grpc::StatusCode::INVALID_ARGUMENT) << wrong;
}

}  // namespace
}  // namespace sightline::tests
