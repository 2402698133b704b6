// Asynchronous calls that end early, or outlive their client.
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "client/async_client.h"
#include "client/scene_upload.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "sightline/v1/query.grpc.pb.h"
#include "sightline/v1/scene.grpc.pb.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/relay.h"
#include "tests/client/support/silent_port.h"

namespace sightline::client {
namespace {

using std::chrono::milliseconds;
using tests::DownwardRays;
using tests::kScene;

class AsyncEnd : public tests::LiveClient {
 protected:
  AsyncEnd() { EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(1), {})); }

  /// A client whose calls stay under way until relay_ is no longer held.
  std::shared_ptr<Client> held_client() {
    auto client = std::make_shared<Client>(*Client::connect(relay_.endpoint()));
    EXPECT_TRUE(client->server_info());
    relay_.hold(true);
    return client;
  }

  tests::Relay relay_{server_->port()};
};

TEST_F(AsyncEnd, AStopEndsACall) {
  const auto client = held_client();
  std::stop_source stop;
  const DownwardRays rays(1, 1);
  const AsyncClient async(*client);
  auto cast = async.cast(kScene, rays.columns(), {}, {.stop = stop.get_token()}).future();
  auto info = async.server_info(stop.get_token()).future();
  auto applied =
      async.apply(kScene, std::vector<Update>{DeleteNode{2}}, {.stop = stop.get_token()}).future();
  auto prefetch = async.prefetch(kScene, {.stop = stop.get_token()}).future();
  auto other = async.get_scene(kScene).future();
  stop.request_stop();
  EXPECT_EQ(cast.get().error().code, Code::kCancelled);
  EXPECT_EQ(info.get().error().code, Code::kCancelled);
  EXPECT_EQ(applied.get().error().code, Code::kCancelled);
  EXPECT_EQ(prefetch.get().error().code, Code::kCancelled);
  relay_.hold(false);
  EXPECT_TRUE(other.get()) << "it has no stop";
}

TEST_F(AsyncEnd, AStopBeforeTheCallEndsIt) {
  std::stop_source stop;
  stop.request_stop();
  const DownwardRays rays(1, 1);
  const AsyncClient async(client_);
  EXPECT_EQ(async.cast(kScene, rays.columns(), {}, {.stop = stop.get_token()})
                .future()
                .get()
                .error()
                .code,
            Code::kCancelled);
  const std::vector<Update> updates{DeleteNode{2}};
  EXPECT_EQ(async.apply(kScene, updates, {.stop = stop.get_token()}).future().get().error().code,
            Code::kCancelled);
  EXPECT_EQ(client_.apply(kScene, updates, {.stop = stop.get_token()}).error().code,
            Code::kCancelled);
  EXPECT_EQ(client_.get_scene(kScene)->revision, 1U);
}

TEST_F(AsyncEnd, TheTimeoutIsADeadline) {
  const tests::SilentPort port;
  const auto client = Client::connect(port.endpoint(), {.timeout = milliseconds(100)});
  ASSERT_TRUE(client);
  const AsyncClient async(*client);
  const DownwardRays rays(1, 1);
  EXPECT_EQ(async.cast(kScene, rays.columns(), {}).future().get().error().code,
            Code::kDeadlineExceeded);
}

TEST_F(AsyncEnd, CallsOutliveTheirClients) {
  auto client = held_client();
  const DownwardRays rays(1, 1);
  std::vector<double> t(1);
  auto async = std::make_unique<AsyncClient>(*client);
  auto cast = async->cast(kScene, rays.columns(), {.t = t}).future();
  auto prefetch = async->prefetch(kScene).future();
  async.reset();
  client.reset();
  relay_.hold(false);
  const auto report = cast.get();
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(t[0], 4);
  EXPECT_TRUE(prefetch.get());
}

// The thread that runs the completion is one of those which end with the last connection.
TEST_F(AsyncEnd, ACompletionMayDestroyTheClient) {
  for (int i = 0; i < 20; ++i) {
    auto client = std::make_shared<Client>(*Client::connect(endpoint(), {.own_connection = true}));
    auto async = std::make_shared<AsyncClient>(*client);
    const auto completed = std::make_shared<std::promise<bool>>();
    auto call = async->get_scene(kScene);
    std::move(call).then([completed, client = std::move(client),
                          async = std::move(async)](const Result<SceneInfo>& scene) mutable {
      async.reset();
      client.reset();
      completed->set_value(scene.ok());
    });
    EXPECT_TRUE(completed->get_future().get());
  }
}

TEST_F(AsyncEnd, AnUpdateIsSentAgainAfterABrokenConnection) {
  const auto through = Client::connect(relay_.endpoint());
  ASSERT_TRUE(through && through->get_scene(kScene));
  relay_.cut();
  const AsyncClient async(*through);
  const auto applied = async.apply(kScene, std::vector<Update>{DeleteNode{2}}).future().get();
  ASSERT_TRUE(applied) << applied.error().message;
  EXPECT_EQ(client_.get_scene(kScene)->revision, 2U);
}

grpc::Status refusal(int seconds) {
  google::rpc::RetryInfo retry;
  retry.mutable_retry_delay()->set_seconds(seconds);
  retry.mutable_retry_delay()->set_nanos(1'000'000);
  google::rpc::Status details;
  details.set_code(grpc::RESOURCE_EXHAUSTED);
  details.add_details()->PackFrom(retry);
  return {grpc::RESOURCE_EXHAUSTED, "come back later", details.SerializeAsString()};
}

namespace v1 = ::sightline::v1;

/// Refuses the first `refusals` calls.
struct Refusing {
  explicit Refusing(int count, int delay) : refusals(count), seconds(delay) {}
  grpc::Status next() {
    if (++calls == 1) first.set_value();
    return calls > refusals ? grpc::Status::OK : refusal(seconds);
  }
  const int refusals, seconds;
  std::atomic<int> calls = 0;
  std::promise<void> first;
};

struct RefusingQueries : v1::RayQueryService::Service, Refusing {
  using Refusing::Refusing;
  grpc::Status CastRays(grpc::ServerContext*, const v1::CastRaysRequest*,
                        v1::CastRaysResponse* response) override {
    response->mutable_served()->set_revision(9);
    return next();
  }
  grpc::Status Prefetch(grpc::ServerContext*, const v1::PrefetchRequest*,
                        grpc::ServerWriter<v1::PrefetchResponse>* writer) override {
    const grpc::Status status = next();
    v1::PrefetchResponse response;
    response.set_done(true);
    response.set_cells_expanded(5);
    if (status.ok()) writer->Write(response);
    return status;
  }
};

/// A server that only has the service.
class Serving {
 public:
  explicit Serving(grpc::Service& service) {
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port_);
    builder.RegisterService(&service);
    server_ = builder.BuildAndStart();
    client_.emplace(*Client::connect("127.0.0.1:" + std::to_string(port_)));
  }
  AsyncClient async() const { return AsyncClient(*client_); }

 private:
  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;
  std::optional<Client> client_;
};

TEST_F(AsyncEnd, WhatIsRefusedForNowIsRepeated) {
  RefusingQueries casts(2, 0), prefetches(2, 0);
  const Serving of_casts(casts), of_prefetches(prefetches);
  const auto report =
      of_casts.async().cast(kScene, DownwardRays(1, 1).columns(), {}).future().get();
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->revision, 9U);
  EXPECT_EQ(casts.calls, 3);
  const auto built = of_prefetches.async().prefetch(kScene).future().get();
  ASSERT_TRUE(built) << built.error().message;
  EXPECT_EQ(built->cells_expanded, 5U);
  EXPECT_EQ(prefetches.calls, 3);
}

TEST_F(AsyncEnd, AStopEndsThePauseBeforeTheNextAttempt) {
  RefusingQueries casts(100, 20);
  const Serving server(casts);
  std::stop_source stop;
  auto cast = server.async()
                  .cast(kScene, DownwardRays(1, 1).columns(), {}, {.stop = stop.get_token()})
                  .future();
  casts.first.get_future().wait();
  stop.request_stop();
  EXPECT_EQ(cast.get().error().code, Code::kCancelled);
}

/// Breaks off twice; what it applies in the end has the id of the first request.
struct BreakingScenes : v1::SceneService::Service {
  grpc::Status ApplyUpdates(grpc::ServerContext*, const v1::ApplyUpdatesRequest* request,
                            v1::ApplyUpdatesResponse* response) override {
    ids.insert(request->request_id());
    response->mutable_revision()->set_revision(7);
    return ++calls < 3 ? grpc::Status(grpc::UNAVAILABLE, "gone") : grpc::Status::OK;
  }
  std::set<std::string> ids;
  int calls = 0;
};

TEST_F(AsyncEnd, ARepeatedUpdateKeepsItsId) {
  BreakingScenes scenes;
  const Serving server(scenes);
  const auto applied = server.async().apply(kScene, {}).future().get();
  ASSERT_TRUE(applied) << applied.error().message;
  EXPECT_EQ(applied->revision, 7U);
  EXPECT_EQ(scenes.calls, 3);
  EXPECT_EQ(scenes.ids.size(), 1U);
}

}  // namespace
}  // namespace sightline::client
