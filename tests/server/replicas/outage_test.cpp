// Several servers while their store is away.
#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <string>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "server/scenes/names.h"
#include "tests/server/replicas/replicas.h"
#include "tests/server/updates/update_stream.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

/// With a PostgreSQL server of its own, which can be killed.
class ReplicaOutage : public ReplicaTest {
 protected:
  void SetUp() override {
    ReplicaTest::SetUp();
    if (IsSkipped()) return;
    postgres_.emplace();
    uri_ = postgres_->uri(postgres_->make_database());
  }
  void TearDown() override {  // before their store
    a_.reset();
    b_.reset();
    c_.reset();
  }

  static bool asks_to_come_back(const grpc::Status& status) {
    google::rpc::Status details;
    if (!details.ParseFromString(status.error_details())) return false;
    for (const auto& detail : details.details()) {
      if (detail.Is<google::rpc::RetryInfo>()) return true;
    }
    return false;
  }

  std::optional<PostgresServer> postgres_;
};

TEST_F(ReplicaOutage, ServesReadsAndRefusesWritesUntilItAnswers) {
  start_three();
  a_->api().make_scene(kScene, planar_sheet(4));
  v1::CastRaysResponse before, reply;
  ASSERT_TRUE(cast_at(a_->api(), {}, &before).ok());
  ASSERT_TRUE(cast_at(b_->api(), before.served().token(), &reply).ok());
  postgres_->kill();
  const grpc::Status refused = b_->api().apply(kScene, {move_to(1, 1)});
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(reason_of(refused), "STORE_IO");
  EXPECT_TRUE(asks_to_come_back(refused));
  for (ReplicaServer* server : {a_.get(), b_.get()}) {
    const grpc::Status cast = cast_at(server->api(), before.served().token(), &reply);
    ASSERT_TRUE(cast.ok()) << cast.error_message();
    EXPECT_EQ(hits_of(reply), hits_of(before));
    ASSERT_TRUE(cast_at(server->api(), {}, &reply).ok());
  }
  EXPECT_NE(b_->readiness().find(" 503 "), std::string::npos);
  wait_until([&] { return b_->metric("sightline_store_reachable") == 0; });
  const grpc::Status unknown = c_->api().create("projects/p/scenes/other");
  EXPECT_EQ(unknown.error_code(), grpc::StatusCode::UNAVAILABLE);
  postgres_->start();
  const v1::ApplyUpdatesResponse written = apply_surely(b_->api(), "again", {move_to(1, 1)});
  EXPECT_EQ(written.revision().revision(), 2u);
  wait_until([&] {
    return cast_at(a_->api(), written.revision().token(), &reply).ok() &&
           cast_at(c_->api(), written.revision().token(), &reply).ok();
  });
  wait_until([&] { return b_->readiness().find(" 200 ") != std::string::npos; });
}

TEST_F(ReplicaOutage, ReadsThatNameNoRevisionEndWhereStalenessIsBounded) {
  b_ = start(
      [](server::ServerConfig& config) { config.max_staleness = std::chrono::milliseconds(1000); });
  b_->api().make_scene(kScene, planar_sheet(4));
  v1::CastRaysResponse before, reply;
  ASSERT_TRUE(cast_at(b_->api(), {}, &before).ok());
  postgres_->kill();
  grpc::Status cast;
  wait_until([&] {
    cast = cast_at(b_->api(), {}, &reply);
    return !cast.ok();
  });
  EXPECT_EQ(reason_of(cast), "STALE");
  EXPECT_EQ(cast.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_TRUE(asks_to_come_back(cast));
  EXPECT_TRUE(cast_at(b_->api(), before.served().token(), &reply).ok()) << "a token is kept";
  postgres_->start();
  wait_until([&] { return cast_at(b_->api(), {}, &reply).ok(); });
}

TEST_F(ReplicaOutage, ATokenThatCannotBeReachedIsRefusedInTime) {
  start_three();
  a_->api().make_scene(kScene, planar_sheet(1));
  v1::CastRaysResponse reply;
  ASSERT_TRUE(cast_at(b_->api(), {}, &reply).ok());
  auto token = server::scenes::RevisionToken::parse(reply.served().token());
  ++token->revision;
  postgres_->kill();
  const grpc::Status cast = cast_at(b_->api(), token->text(), &reply);
  EXPECT_EQ(cast.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(reason_of(cast), "REVISION_NOT_THERE");
  EXPECT_TRUE(asks_to_come_back(cast));
}

}  // namespace
}  // namespace sightline::tests
