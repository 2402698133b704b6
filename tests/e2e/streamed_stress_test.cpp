// A producer streams updates of every kind, is disconnected and resumes, while others cast: every
// batch is applied once, and every answer equals brute force at the revision it names.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "tests/e2e/streaming_producer.h"

namespace sightline::tests {
namespace {

constexpr int kCasters = 3;

class StreamedStress : public LiveServer {};

TEST_F(StreamedStress, EveryBatchIsAppliedOnceThroughBrokenCalls) {
  ServedStress stress(stress_updates(150));
  ASSERT_NO_FATAL_FAILURE(begin(api_, stress));
  std::atomic<bool> over{false};
  std::vector<std::jthread> clients;
  for (int i = 0; i < kCasters; ++i) {
    clients.emplace_back([&, i] {
      CastingClient client(stress, server_->port(), static_cast<std::uint64_t>(i));
      while (!over && !HasFailure()) client.cast();
    });
  }
  StreamingProducer producer(stress, server_->port(), 77);
  for (std::uint64_t part = 1; part <= 4 && !HasFailure(); ++part)
    producer.stream(stress.wanted * part / 5, true);
  if (!HasFailure()) producer.stream(stress.wanted, false);
  over = true;
  clients.clear();
  EXPECT_EQ(api_.get(kMovingScene).head().revision(), stress.history.latest()->revision());
  EXPECT_GT(stress.refused, stress.wanted / 20);
  EXPECT_GT(stress.casts, 0u);
  RecordProperty("casts", std::to_string(stress.casts));
}

}  // namespace
}  // namespace sightline::tests
