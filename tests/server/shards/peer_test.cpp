// Which peers are lost, and found again.
#include "server/shards/peer.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "server/shards/peers.h"
#include "tests/client/support/temp_dir.h"
#include "tests/server/support/fake_peers.h"
#include "tests/support/sleep_shortly.h"

namespace sightline::server::shards {
namespace {

using tests::MutePeer;
using tests::SlowPeer;

/// A cast without a deadline.
struct OpenCast {
  explicit OpenCast(Peer& peer) {
    const auto stub = peer.begin(context);
    if (stub == nullptr) return;
    stub->async()->CastRays(context.get(), &request, &reply, [this, &peer](grpc::Status status) {
      ended.set_value(peer.end(context, std::move(status)));
    });
    begun = true;
  }

  Peer::Context context = std::make_shared<grpc::ClientContext>();
  v1::CastRaysRequest request;
  v1::CastRaysResponse reply;
  std::promise<grpc::Status> ended;
  bool begun = false;
};

class PeerTest : public testing::Test {
 protected:
  std::string path() const { return sockets_.path("peer"); }
  Peer& peer() const { return peers_->peer(0); }

  void lose() const {
    for (std::uint32_t i = 0; i <= kPingsUntilLost; ++i) peer().ping();
  }
  template <class Done>
  static void wait_until(const Done& done) {
    while (!done()) tests::sleep_shortly();
  }

  PeerSettings settings() const {
    PeerSettings settings;
    settings.addresses = "unix:" + path() + ",unix:" + sockets_.path("other");
    return settings;
  }

  tests::TempDir sockets_;
  Result<Peers> peers_ = Peers::make(settings());
};

TEST_F(PeerTest, IsLostWhenItAnswersNoPing) {
  const MutePeer mute(path());
  for (std::uint32_t i = 1; i <= kPingsUntilLost; ++i) {
    peer().ping();
    EXPECT_EQ(peer().unanswered(), i);
    EXPECT_FALSE(peer().is_lost());
  }
  peer().ping();
  EXPECT_TRUE(peer().is_lost());
  const grpc::Status lost = peer().lost_status();
  EXPECT_EQ(lost.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(lost.error_message(), "it has answered none of the last 9 pings");
}

TEST_F(PeerTest, IsNotLostWhileItWorks) {
  const SlowPeer slow(path());
  OpenCast cast(peer());
  wait_until([&] { return slow.begun() == 1; });
  for (std::uint32_t i = 0; i < 3 * kPingsUntilLost; ++i) {
    peer().ping();
    wait_until([&] { return peer().unanswered() == 0; });
  }
  EXPECT_FALSE(peer().is_lost());
  EXPECT_EQ(slow.cancelled(), 0);
  cast.context->TryCancel();
  EXPECT_EQ(cast.ended.get_future().get().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(PeerTest, EndsItsCallsWhenItIsLost) {
  const MutePeer mute(path());
  OpenCast open(peer());
  ASSERT_TRUE(open.begun);
  lose();
  EXPECT_EQ(open.ended.get_future().get().error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_FALSE(OpenCast(peer()).begun);
}

TEST_F(PeerTest, IsFoundWhenItIsBack) {
  std::optional<MutePeer> mute(path());
  lose();
  mute.reset();
  ASSERT_EQ(unlink(path().c_str()), 0);
  const SlowPeer back(path());
  while (peer().is_lost()) {
    peer().ping();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  OpenCast cast(peer());
  ASSERT_TRUE(cast.begun);
  wait_until([&] { return back.begun() == 1; });
  cast.context->TryCancel();
  cast.ended.get_future().wait();
}

TEST_F(PeerTest, ThatIsGoneIsLostWithTheReason) {
  const auto has_reason = [&] {
    return peer().lost_status().error_message().find("pings: ") != std::string::npos;
  };
  while (!peer().is_lost() || !has_reason()) {
    peer().ping();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

}  // namespace
}  // namespace sightline::server::shards
