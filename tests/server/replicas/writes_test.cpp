// Writes to one scene through several servers.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <barrier>
#include <chrono>
#include <compare>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/server/replicas/replicas.h"
#include "tests/server/updates/update_stream.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

v1::Update delete_node(std::int64_t node) {
  v1::Update update;
  update.mutable_delete_node()->set_node(node);
  return update;
}

class ReplicaWrites : public ReplicaTest {
 protected:
  void SetUp() override {
    ReplicaTest::SetUp();
    if (IsSkipped()) return;
    start_three();
    ASSERT_TRUE(a_->api().create(kScene).ok());
  }
};

TEST_F(ReplicaWrites, RevisionsHaveNoGapsAndEachBatchIsThereOnce) {
  constexpr int kEach = 40;
  struct Made {
    std::uint64_t revision = 0, node = 0;
  };
  std::mutex mutex;
  std::vector<Made> made;
  std::vector<std::thread> writers;
  for (ReplicaServer* server : {a_.get(), b_.get(), c_.get()}) {
    for (int writer = 0; writer < 2; ++writer) {
      writers.emplace_back([&, server, writer] {
        Api api(server->connect_again());
        for (int i = 0; i < kEach; ++i) {
          const std::string id = std::to_string(reinterpret_cast<std::uintptr_t>(server)) + "-" +
                                 std::to_string(writer) + "-" + std::to_string(i);
          const v1::ApplyUpdatesResponse reply = apply_surely(api, id, {put_node(-1)});
          const std::lock_guard lock(mutex);
          made.push_back({reply.revision().revision(), reply.nodes(0)});
        }
      });
    }
  }
  for (std::thread& writer : writers) writer.join();
  std::ranges::sort(made, {}, &Made::revision);
  for (std::size_t i = 0; i < made.size(); ++i) {
    EXPECT_EQ(made[i].revision, i + 1);
    EXPECT_EQ(made[i].node, i + 1);
  }
  v1::ApplyUpdatesResponse last;
  ASSERT_TRUE(a_->api().apply(kScene, {}, &last).ok());
  EXPECT_EQ(last.revision().revision(), 6u * kEach + 1);
  for (ReplicaServer* server : {b_.get(), c_.get()}) {
    v1::BatchGetNodesResponse nodes;
    ASSERT_TRUE(
        nodes_at(server->api(), last.revision().token(), {6 * kEach, 6 * kEach + 1}, &nodes).ok());
    EXPECT_EQ(nodes.nodes(0).id(), 6u * kEach);
    EXPECT_EQ(nodes.nodes(1).id(), 0u) << "no batch is there twice";
  }
}

TEST_F(ReplicaWrites, ARequestThatIsRepeatedAtAnotherServerGetsItsAnswer) {
  const std::vector<v1::Update> put{put_node(-1), put_node(-2, {}, -1)};
  v1::ApplyUpdatesResponse first, repeat;
  ASSERT_TRUE(apply_request(a_->api(), request_of("one", put), &first).ok());
  for (ReplicaServer* server : {b_.get(), c_.get()}) {
    const grpc::Status repeated = apply_request(server->api(), request_of("one", put), &repeat);
    ASSERT_TRUE(repeated.ok()) << repeated.error_message();
    EXPECT_TRUE(repeat.replayed());
    EXPECT_EQ(repeat.revision().token(), first.revision().token());
    EXPECT_EQ(repeat.nodes(1), first.nodes(1));
    EXPECT_EQ(reason_of(apply_request(server->api(), request_of("one", {}), &repeat)),
              "REQUEST_ID_REUSED");
  }
  // What was applied cannot be applied again.
  const auto request = request_of("two", {delete_node(2)});
  ASSERT_TRUE(apply_request(b_->api(), request, &first).ok());
  ASSERT_TRUE(apply_request(c_->api(), request, &repeat).ok());
  EXPECT_TRUE(repeat.replayed());
  EXPECT_EQ(repeat.revision().revision(), first.revision().revision());
}

TEST_F(ReplicaWrites, ARequestThatComesToAllAtOnceIsAppliedOnce) {
  for (int round = 0; round < 20; ++round) {
    const auto request = request_of("round " + std::to_string(round), {put_node(-1)});
    std::vector<v1::ApplyUpdatesResponse> replies(3);
    std::vector<std::thread> senders;
    std::size_t next = 0;
    for (ReplicaServer* server : {a_.get(), b_.get(), c_.get()}) {
      senders.emplace_back([&, server, reply = &replies[next++]] {
        const grpc::Status applied = apply_request(server->api(), request, reply);
        EXPECT_TRUE(applied.ok()) << applied.error_message();
      });
    }
    for (std::thread& sender : senders) sender.join();
    for (const auto& reply : replies) {
      EXPECT_EQ(reply.revision().revision(), static_cast<std::uint64_t>(round + 1));
      EXPECT_EQ(reply.nodes(0), static_cast<std::uint64_t>(round + 1));
    }
    EXPECT_EQ(std::ranges::count_if(replies, [](const auto& reply) { return !reply.replayed(); }),
              1);
  }
}

TEST_F(ReplicaWrites, ARequestThatIsSentTwiceAmongOtherWritersHasOneAnswer) {
  constexpr int kEach = 40;
  struct Made {
    std::uint64_t revision = 0, node = 0;
    auto operator<=>(const Made&) const = default;
  };
  std::mutex mutex;
  std::map<std::string, std::set<Made>> made;
  std::vector<std::thread> senders;
  std::deque<std::barrier<>> together;
  for (ReplicaServer* server : {a_.get(), b_.get(), c_.get()}) {
    const std::string name = std::to_string(together.size());
    std::barrier<>& barrier = together.emplace_back(3);
    for (int sender = 0; sender < 2; ++sender) {
      senders.emplace_back([&, server, name] {
        Api api(server->connect_again());
        for (int i = 0; i < kEach; ++i) {
          const std::string id = name + "-" + std::to_string(i);
          barrier.arrive_and_wait();
          const v1::ApplyUpdatesResponse reply = apply_surely(api, id, {put_node(-1)});
          const std::lock_guard lock(mutex);
          made[id].insert(
              {reply.revision().revision(), reply.nodes_size() > 0 ? reply.nodes(0) : 0});
        }
      });
    }
    // One that does not wait for its answer.
    senders.emplace_back([&, server, name] {
      Api api(server->connect_again());
      for (int i = 0; i < kEach; ++i) {
        const auto request = request_of(name + "-" + std::to_string(i), {put_node(-1)});
        barrier.arrive_and_wait();
        grpc::ClientContext context;
        context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(i % 8));
        v1::ApplyUpdatesResponse reply;
        static_cast<void>(api.scenes->ApplyUpdates(&context, request, &reply));
      }
    });
  }
  for (std::thread& sender : senders) sender.join();
  std::set<Made> all;
  for (const auto& [id, answers] : made) {
    EXPECT_EQ(answers.size(), 1u) << id;
    all.insert(answers.begin(), answers.end());
  }
  std::uint64_t next = 0;
  for (const Made& one : all) {
    EXPECT_EQ(one.revision, ++next);
    EXPECT_EQ(one.node, next);
  }
  EXPECT_EQ(next, 3u * kEach);
}

v1::CastRaysRequest cast_with(const std::string& id, const std::vector<v1::Update>& updates) {
  v1::CastRaysRequest request = cast_request(kScene, rays_downward(4));
  request.mutable_apply()->set_request_id(id);
  request.mutable_apply()->mutable_updates()->Assign(updates.begin(), updates.end());
  return request;
}

TEST_F(ReplicaWrites, CastsWithUpdatesAreAnsweredAtTheirRevisionsWhoeverElseWrites) {
  constexpr int kEach = 30;
  const std::string mesh = a_->api().add_mesh(planar_sheet(1));
  ASSERT_TRUE(a_->api().apply(kScene, {put_node(-1, mesh)}).ok());
  std::vector<std::thread> writers;
  int number = 0;
  for (ReplicaServer* server : {a_.get(), b_.get(), c_.get()}) {
    writers.emplace_back([&, server, number = number++] {
      Api api(server->connect_again());
      for (int i = 0; i < kEach; ++i) {
        const double z = (1 + number * kEach + i) / 64.0;
        v1::Update lift;
        const double rows[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, z};
        lift.mutable_set_transforms()->add_nodes(1);
        lift.mutable_set_transforms()->set_matrices(rows, sizeof(rows));
        const auto request = cast_with(std::to_string(number) + "/" + std::to_string(i), {lift});
        v1::CastRaysResponse reply;
        grpc::Status cast;
        do cast = api.cast(request, &reply);  // others may commit first, too often
        while (cast.error_code() == grpc::StatusCode::UNAVAILABLE);
        ASSERT_TRUE(cast.ok()) << cast.error_message();
        EXPECT_EQ(column_values<double>(reply, v1::HIT_FIELD_T).front(), 10 - z);
        EXPECT_EQ(reply.served().token(), reply.applied().revision().token());
        EXPECT_EQ(reply.applied().durability(), v1::DURABILITY_COMMITTED);
      }
    });
  }
  for (std::thread& writer : writers) writer.join();
  v1::ApplyUpdatesResponse last;
  ASSERT_TRUE(a_->api().apply(kScene, {}, &last).ok());
  EXPECT_EQ(last.revision().revision(), 3u * kEach + 2) << "each is applied once";
}

TEST_F(ReplicaWrites, ACastWithUpdatesThatIsRepeatedAtAnotherServerHasItsRevision) {
  const std::string mesh = a_->api().add_mesh(planar_sheet(1));
  v1::CastRaysResponse first, repeat;
  const auto request = cast_with("one", {put_node(-1, mesh)});
  ASSERT_TRUE(a_->api().cast(request, &first).ok());
  for (ReplicaServer* server : {b_.get(), c_.get()}) {
    const grpc::Status repeated = server->api().cast(request, &repeat);
    ASSERT_TRUE(repeated.ok()) << repeated.error_message();
    EXPECT_TRUE(repeat.applied().replayed());
    EXPECT_EQ(repeat.served().token(), first.served().token());
    EXPECT_EQ(repeat.applied().nodes(0), first.applied().nodes(0));
    EXPECT_EQ(hits_of(repeat), hits_of(first));
    EXPECT_EQ(reason_of(server->api().cast(cast_with("one", {}), &repeat)), "REQUEST_ID_REUSED");
  }
  // What was applied cannot be applied again.
  const auto removal = cast_with("two", {delete_node(1)});
  ASSERT_TRUE(b_->api().cast(removal, &first).ok());
  ASSERT_TRUE(c_->api().cast(removal, &repeat).ok());
  EXPECT_TRUE(repeat.applied().replayed());
  EXPECT_EQ(repeat.served().revision(), 2u);
  // All at once.
  for (int round = 0; round < 10; ++round) {
    const auto put = cast_with("round " + std::to_string(round), {put_node(-1, mesh)});
    std::vector<v1::CastRaysResponse> replies(3);
    std::vector<std::thread> senders;
    std::size_t next = 0;
    for (ReplicaServer* server : {a_.get(), b_.get(), c_.get()}) {
      senders.emplace_back([&put, server, reply = &replies[next++]] {
        grpc::Status cast;
        do cast = server->api().cast(put, reply);
        while (cast.error_code() == grpc::StatusCode::UNAVAILABLE);
        EXPECT_TRUE(cast.ok()) << cast.error_message();
      });
    }
    for (std::thread& sender : senders) sender.join();
    for (const auto& reply : replies) {
      EXPECT_EQ(reply.applied().revision().revision(), static_cast<std::uint64_t>(round + 3));
      EXPECT_GE(reply.served().revision(), reply.applied().revision().revision());
    }
  }
}

TEST_F(ReplicaWrites, AnExpectedRevisionIsThatOfAllServers) {
  v1::ApplyUpdatesResponse reply;
  auto request = request_of("", {put_node(-1)});
  for (std::uint64_t i = 0; i < 20; ++i) {
    ReplicaServer& server = i % 2 == 0 ? *a_ : *b_;
    request.set_expected_revision(i);
    const grpc::Status applied = apply_request(server.api(), request, &reply);
    ASSERT_TRUE(applied.ok()) << applied.error_message();
    const grpc::Status late = apply_request(c_->api(), request, &reply);
    EXPECT_EQ(late.error_code(), grpc::StatusCode::ABORTED);
    EXPECT_EQ(reason_of(late), "REVISION_MISMATCH");
  }
}

TEST_F(ReplicaWrites, AnUpdateMayNameWhatAnotherServerHasJustMade) {
  for (int i = 0; i < 20; ++i) {
    v1::ApplyUpdatesResponse made;
    const std::string mesh = a_->api().add_mesh(planar_sheet(static_cast<std::uint32_t>(i + 1)));
    ASSERT_TRUE(a_->api().apply(kScene, {put_node(-1, mesh)}, &made).ok());
    const grpc::Status moved = b_->api().apply(kScene, {move_to(made.nodes(0), i)});
    ASSERT_TRUE(moved.ok()) << moved.error_message();
    const grpc::Status used = c_->api().apply(kScene, {put_node(-1, mesh)});
    ASSERT_TRUE(used.ok()) << used.error_message();
  }
  EXPECT_EQ(reason_of(b_->api().apply(kScene, {move_to(1000, 1)})), "NODE_NOT_FOUND");
}

TEST_F(ReplicaWrites, AProducerGoesOnAtAnotherServer) {
  std::uint64_t sequence = 0;
  for (int round = 0; round < 6; ++round) {
    ReplicaServer* const servers[] = {a_.get(), b_.get(), c_.get()};
    UpdateStream stream(servers[round % 3]->api());
    const v1::ProducerOpened opened = stream.open(kScene);
    EXPECT_EQ(opened.last_committed(), sequence);
    EXPECT_EQ(opened.revision().revision(), sequence);
    if (sequence > 0) {
      ASSERT_GT(opened.put_size(), 0);
      const v1::PutNodes& last = opened.put(opened.put_size() - 1);
      EXPECT_EQ(last.sequence(), sequence);
      EXPECT_EQ(last.nodes(0), sequence);
    }
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(stream.send(++sequence, {put_node(-1)}));
    stream.read_up_to(sequence);
    stream.close();
    EXPECT_TRUE(stream.finish().ok());
  }
  EXPECT_EQ(c_->api().get(kScene).head().revision(), sequence);
}

TEST_F(ReplicaWrites, ABatchThatCameThroughTwoServersIsAppliedOnce) {
  UpdateStream old(a_->api()), next(b_->api());
  old.open(kScene);
  ASSERT_TRUE(old.send(1, {put_node(-1)}));
  old.read_up_to(1);
  EXPECT_EQ(next.open(kScene).last_committed(), 1u);
  ASSERT_TRUE(next.send(2, {put_node(-1)}));
  next.read_up_to(2);
  ASSERT_TRUE(old.send(2, {put_node(-1)}));  // the client had sent it before it went on elsewhere
  const auto answers = old.read_up_to(2);
  EXPECT_TRUE(answers.back().has_ack());
  EXPECT_EQ(answers.back().ack().put(0).nodes(0), 2u);
  v1::ApplyUpdatesResponse reply;
  ASSERT_TRUE(a_->api().apply(kScene, {put_node(-1)}, &reply).ok());
  EXPECT_EQ(reply.revision().revision(), 3u);
  EXPECT_EQ(reply.nodes(0), 3u);
}

TEST_F(ReplicaWrites, StreamsOfAllServersShareAScene) {
  constexpr std::uint64_t kBatches = 60;
  std::vector<std::thread> producers;
  std::vector<std::vector<std::uint64_t>> revisions(3);
  std::size_t next = 0;
  for (ReplicaServer* server : {a_.get(), b_.get(), c_.get()}) {
    producers.emplace_back([&, server, mine = next++] {
      Api api(server->connect_again());
      const std::string name = "producer-" + std::to_string(mine);
      std::uint64_t sent = 0, acknowledged = 0;
      while (acknowledged < kBatches) {
        UpdateStream stream(api);
        if (!stream.send_open(kScene, name)) continue;
        v1::StreamUpdatesResponse answer;
        if (!stream.read(answer)) continue;
        sent = acknowledged = answer.opened().last_committed();
        for (;;) {
          while (sent < kBatches && sent < acknowledged + 8) stream.send(++sent, {put_node(-1)});
          if (acknowledged == kBatches || !stream.read(answer)) break;
          EXPECT_TRUE(answer.has_ack());
          acknowledged = answer.ack().up_to_sequence();
          revisions[mine].push_back(answer.ack().revision().revision());
        }
      }
    });
  }
  for (std::thread& producer : producers) producer.join();
  for (const auto& reported : revisions) EXPECT_TRUE(std::ranges::is_sorted(reported));
  v1::ApplyUpdatesResponse last;
  ASSERT_TRUE(b_->api().apply(kScene, {put_node(-1)}, &last).ok());
  EXPECT_EQ(last.revision().revision(), 3 * kBatches + 1);
  EXPECT_EQ(last.nodes(0), 3 * kBatches + 1);
}

TEST_F(ReplicaWrites, ProducersThatMoveBetweenServersHaveEachBatchOnce) {
  constexpr std::uint64_t kBatches = 50;
  constexpr int kProducers = 3;
  ReplicaServer* const servers[] = {a_.get(), b_.get(), c_.get()};
  std::mutex mutex;
  std::map<std::pair<std::string, std::uint64_t>, std::set<std::uint64_t>> nodes;
  const auto note = [&](const std::string& producer, const auto& put) {
    const std::lock_guard lock(mutex);
    for (const v1::PutNodes& batch : put)
      nodes[{producer, batch.sequence()}].insert(batch.nodes().begin(), batch.nodes().end());
  };
  // Each producer twice, at different servers; they leave without reading all answers.
  const auto produce = [&](int number, int copy) {
    Random random(static_cast<std::uint64_t>(2 * number + copy));
    std::deque<Api> apis;
    for (ReplicaServer* server : servers) apis.emplace_back(server->connect_again());
    const std::string name = "producer-" + std::to_string(number);
    std::uint64_t acknowledged = 0;
    for (int visit = number + copy; acknowledged < kBatches; ++visit) {
      UpdateStream stream(apis[static_cast<std::size_t>(visit) % apis.size()]);
      v1::StreamUpdatesResponse answer;
      if (!stream.send_open(kScene, name) || !stream.read(answer)) continue;
      note(name, answer.opened().put());
      std::uint64_t sent = acknowledged = answer.opened().last_committed();
      for (std::uint64_t left = random.below(12); acknowledged < kBatches && left > 0; --left) {
        while (sent < kBatches && sent < acknowledged + 8) stream.send(++sent, {put_node(-1)});
        if (!stream.read(answer)) break;
        ASSERT_TRUE(answer.has_ack()) << answer.reject().message();
        note(name, answer.ack().put());
        acknowledged = answer.ack().up_to_sequence();
      }
    }
  };
  std::vector<std::thread> producers;
  for (int number = 0; number < kProducers; ++number) {
    for (int copy = 0; copy < 2; ++copy) producers.emplace_back(produce, number, copy);
  }
  for (std::thread& producer : producers) producer.join();
  v1::ApplyUpdatesResponse last;
  ASSERT_TRUE(b_->api().apply(kScene, {put_node(-1)}, &last).ok());
  EXPECT_EQ(last.revision().revision(), kProducers * kBatches + 1);
  EXPECT_EQ(last.nodes(0), kProducers * kBatches + 1);
  std::set<std::uint64_t> all;
  for (const auto& [batch, put] : nodes) {
    EXPECT_EQ(put.size(), 1u) << batch.first << " " << batch.second;
    all.insert(put.begin(), put.end());
  }
  EXPECT_EQ(all.size(), nodes.size()) << "a node is of two batches";
}

TEST_F(ReplicaWrites, AnInvalidBatchOfAProducerIsRejectedOnly) {
  UpdateStream stream(b_->api());
  stream.open(kScene);
  v1::ApplyUpdatesResponse made;
  ASSERT_TRUE(a_->api().apply(kScene, {put_node(-1)}, &made).ok());
  ASSERT_TRUE(stream.send(1, {move_to(made.nodes(0), 1)}));
  ASSERT_TRUE(stream.send(2, {move_to(77, 1)}));
  ASSERT_TRUE(stream.send(3, {put_node(-1)}));
  bool rejected = false;
  for (const auto& answer : stream.read_up_to(3)) {
    if (!answer.has_reject()) continue;
    EXPECT_EQ(answer.reject().sequence(), 2u);
    rejected = true;
  }
  EXPECT_TRUE(rejected);
  EXPECT_EQ(x_of(b_->api(), kScene, made.nodes(0)), 1);
  UpdateStream later(c_->api());
  EXPECT_EQ(later.open(kScene).last_committed(), 3u);
}

}  // namespace
}  // namespace sightline::tests
