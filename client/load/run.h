// One run: workers that send requests by a schedule, and the record of the answers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>

#include "client/load/clock.h"
#include "client/load/record.h"
#include "client/load/schedule.h"
#include "client/load/target.h"

namespace sightline::client::load {

/// A run ends with the first of its ends that is reached.
struct RunOptions {
  Schedule schedule = Schedule::closed();
  /// How many requests may be in flight. Requests of an open loop that are due while all are wait,
  /// and their latency counts.
  std::size_t workers = 1;
  Nanoseconds warm_up{};
  Nanoseconds window = std::chrono::seconds(1);
  std::optional<std::uint64_t> requests{};      ///< an end: this number, the warm-up's included
  bool until_stable = false;                    ///< an end: is_stable()
  Nanoseconds most = std::chrono::seconds(60);  ///< an end: this long after the warm-up
  /// How long requests that are due or in flight at the end may take; then they are cancelled. A
  /// request that is not answered by then, or was not sent, counts as failed if `is_strict`.
  Nanoseconds drain = std::chrono::seconds(10);
  bool is_strict = true;
};

struct Run {
  Record record;
  bool stable = false;     ///< it ended with is_stable()
  bool complete = true;    ///< it was not ended by a stop, nor by `most` before `requests`
  std::uint64_t sent = 0;  ///< requests
};

/// Called about ten times a second on the thread of run().
using RunProgress = std::function<void(Nanoseconds elapsed, std::uint64_t rays)>;

/// Times in the record count from the call. A requested stop ends the run early. With one worker
/// and a clock that is set by the target, all of the record follows from the arguments.
Run run(const RunOptions& options, Target& target, Clock& clock, const std::stop_token& stop,
        const RunProgress& progress = {});

}  // namespace sightline::client::load
