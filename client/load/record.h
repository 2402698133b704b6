// What a run measures: latencies, counts, shares of time and progress.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/load/clock.h"
#include "client/load/histogram.h"
#include "client/load/target.h"

namespace sightline::client::load {

/// Times since the start of the run.
struct Timing {
  Nanoseconds due{};   ///< when the request should have been sent; a closed loop: when it was
  Nanoseconds sent{};  ///< at or after `due`
  Nanoseconds done{};
};

/// The requests that were done within an interval of fixed length.
struct Window {
  Nanoseconds begin{};
  Nanoseconds length{};
  std::uint64_t rays = 0;
  Histogram latency;

  double rays_per_s() const { return static_cast<double>(rays) / seconds_of(length); }
};

/// How many rays were answered up to a time.
struct Answered {
  Nanoseconds time{};
  std::uint64_t rays = 0;
};

/// A record of the casts that were due after the warm-up. Latencies are in nanoseconds, from `due`
/// to `done`.
struct Record {
  Histogram latency;
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;
  std::uint64_t refused = 0;
  std::uint64_t failed = 0;
  std::string first_error;  ///< a refused or failed request's

  Histogram update_latency;
  std::uint64_t updates_failed = 0;  ///< failed or refused

  /// Sums over answered casts: what the server reports, and the time from `sent` to `done`.
  Nanoseconds queue{}, build{}, trace{}, in_flight{};
  /// The part of `in_flight` that the server reports neither as queue nor as trace, for requests
  /// that were sent before the first answer came. A full build is in it.
  Nanoseconds unreported_before_first_answer{};

  std::optional<Nanoseconds> first_hit, last_hit;  ///< when the answers came that have them
  Nanoseconds begin{};                             ///< the end of the warm-up
  Nanoseconds end{};                               ///< when the last answer came
  std::vector<Window> windows;                     ///< without gaps; the last may be unfinished
  std::vector<Answered> progress;                  ///< in order of time

  double elapsed_s() const { return seconds_of(end - begin); }
};

/// Adds a request. `window` is the length of windows.
void add_to(Record& record, const Timing& timing, const Outcome& outcome, Nanoseconds window);

/// Whether the median and the 99th percentile of the last kStableWindows windows that ended before
/// `now` differ by at most kStableSpread, and each has at least kStableRequests.
bool is_stable(const Record& record, Nanoseconds now);
inline constexpr std::size_t kStableWindows = 3;
inline constexpr double kStableSpread = 0.05;
inline constexpr std::uint64_t kStableRequests = 100;

/// The mean over the whole run. 0 if nothing was answered.
double mean_rays_per_s(const Record& record);
/// The median of the windows that ended before the last answer, which a neighbour on the machine
/// disturbs less; or, if there are fewer than kStableWindows, the mean.
double steady_rays_per_s(const Record& record);

}  // namespace sightline::client::load
