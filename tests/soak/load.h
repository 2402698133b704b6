// The kinds of load of a soak. Each load has its own connections and runs until it is stopped.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/e2e/streaming_producer.h"
#include "tests/soak/window.h"

namespace sightline::tests::soak {

/// What all loads share, and what they have done. Answers that differ from brute force, and calls
/// that fail, fail the test (testing::Test::HasFailure()).
struct Progress {
  std::atomic<bool> over{false};
  std::atomic<std::uint64_t> casts{0}, rays{0}, judged{0};
  std::atomic<std::uint64_t> scenes{0}, uploads{0}, connections{0};
  Latencies latencies;  ///< Of the casts of fixed_casts().

  bool done() const { return over || testing::Test::HasFailure(); }
};

/// Of the casts of every load, one in this many is compared with brute force.
inline constexpr std::uint64_t kOneIn = 100;

/// Streams random updates of all kinds to the moving scene, and breaks the call now and then.
void stream_updates(Progress& progress, ServedStress& stress, int port);
/// Casts at the moving scene.
void moving_casts(Progress& progress, ServedStress& stress, int port, std::uint64_t seed);
/// Casts large batches at a scene that does not change; makes the scene first.
void fixed_casts(Progress& progress, int port);
/// Makes a scene of a new mesh on a new connection, casts, deletes it, and so on.
void come_and_go(Progress& progress, int port);

}  // namespace sightline::tests::soak
