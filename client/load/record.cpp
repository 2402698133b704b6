// Adds requests to a record, and judges its windows.
#include "client/load/record.h"

#include <algorithm>
#include <cstddef>
#include <span>

namespace sightline::client::load {
namespace {

// The progress of a long run is thinned, so that it stays small.
constexpr std::size_t kMostPoints = 4096;

Nanoseconds microseconds(std::uint64_t count) { return std::chrono::microseconds(count); }

Window& window_at(Record& record, Nanoseconds time, Nanoseconds length) {
  const auto index = static_cast<std::size_t>(
      std::max<std::int64_t>((time - record.begin).count() / length.count(), 0));
  while (record.windows.size() <= index) {
    const auto next = static_cast<std::int64_t>(record.windows.size());
    record.windows.push_back({record.begin + next * length, length, 0, {}});
  }
  return record.windows[index];
}

void add_progress(Record& record, Nanoseconds time) {
  if (record.progress.size() >= kMostPoints) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < record.progress.size(); i += 2)
      record.progress[kept++] = record.progress[i];
    record.progress.resize(kept);
  }
  record.progress.push_back({time, record.rays});
}

void add_answer(Record& record, const Timing& timing, const Outcome& outcome, Nanoseconds window) {
  const Nanoseconds first_answer =
      record.progress.empty() ? timing.done : record.progress.front().time;
  const Nanoseconds in_flight = timing.done - timing.sent;
  const Nanoseconds reported = microseconds(outcome.queue_us + outcome.trace_us);
  record.queue += microseconds(outcome.queue_us);
  record.build += microseconds(outcome.build_us);
  record.trace += microseconds(outcome.trace_us);
  record.in_flight += in_flight;
  if (timing.sent < first_answer)
    record.unreported_before_first_answer += std::max(in_flight - reported, Nanoseconds{});
  const auto latency = static_cast<std::uint64_t>((timing.done - timing.due).count());
  record.latency.add(latency);
  record.rays += outcome.rays;
  record.hits += outcome.hits;
  record.end = std::max(record.end, timing.done);
  if (outcome.hits > 0) {
    record.first_hit = std::min(record.first_hit.value_or(timing.done), timing.done);
    record.last_hit = std::max(record.last_hit.value_or(timing.done), timing.done);
  }
  add_progress(record, timing.done);
  Window& current = window_at(record, timing.done, window);
  current.rays += outcome.rays;
  current.latency.add(latency);
}

}  // namespace

void add_to(Record& record, const Timing& timing, const Outcome& outcome, Nanoseconds window) {
  using State = Outcome::State;
  if (timing.due < record.begin || outcome.state == State::kCancelled) return;
  if (outcome.state != State::kAnswered && record.first_error.empty())
    record.first_error = outcome.error;
  if (outcome.is_update) {
    if (outcome.state != State::kAnswered) {
      ++record.updates_failed;
    } else {
      record.update_latency.add(static_cast<std::uint64_t>((timing.done - timing.due).count()));
    }
    return;
  }
  if (outcome.state == State::kRefused) ++record.refused;
  if (outcome.state == State::kFailed) ++record.failed;
  if (outcome.state == State::kAnswered) add_answer(record, timing, outcome, window);
}

bool is_stable(const Record& record, Nanoseconds now) {
  std::size_t ended = record.windows.size();
  while (ended > 0 && record.windows[ended - 1].begin + record.windows[ended - 1].length > now)
    --ended;
  if (ended < kStableWindows) return false;
  const auto last = std::span(record.windows).subspan(ended - kStableWindows, kStableWindows);
  const auto is_steady = [&](double share) {
    std::uint64_t low = ~std::uint64_t{0}, high = 0;
    for (const Window& window : last) {
      low = std::min(low, window.latency.quantile(share));
      high = std::max(high, window.latency.quantile(share));
    }
    return static_cast<double>(high) <= static_cast<double>(low) * (1 + kStableSpread);
  };
  return std::all_of(
             last.begin(), last.end(),
             [](const Window& window) { return window.latency.count() >= kStableRequests; }) &&
         is_steady(0.5) && is_steady(0.99);
}

double mean_rays_per_s(const Record& record) {
  const double elapsed = record.elapsed_s();
  return elapsed > 0 ? static_cast<double>(record.rays) / elapsed : 0;
}

double steady_rays_per_s(const Record& record) {
  std::vector<double> rates;
  for (const Window& window : record.windows) {
    if (window.begin + window.length <= record.end) rates.push_back(window.rays_per_s());
  }
  if (rates.size() < kStableWindows) return mean_rays_per_s(record);
  std::sort(rates.begin(), rates.end());
  const std::size_t middle = rates.size() / 2;
  return rates.size() % 2 == 1 ? rates[middle] : (rates[middle - 1] + rates[middle]) / 2;
}

}  // namespace sightline::client::load
