// Reads google.rpc.RetryInfo, and waits longer from refusal to refusal.
#include "client/calls/retries.h"

#include <google/protobuf/util/time_util.h>

#include <algorithm>
#include <random>

#include "client/calls/connection.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace sightline::client::calls {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLongest{60'000};
constexpr milliseconds kLongestPause{8'000};
constexpr int kFirstDoubled = 3;  // refusals in a row from which on pauses grow

/// A pause from 1 to 1.5 times as long.
milliseconds scattered(milliseconds pause) {
  thread_local std::minstd_rand random{std::random_device{}()};
  return pause +
         milliseconds(std::uniform_int_distribution<std::int64_t>(0, pause.count() / 2)(random));
}

}  // namespace

std::optional<milliseconds> retry_delay(const grpc::Status& status) {
  google::rpc::Status details;
  if (status.error_code() != grpc::RESOURCE_EXHAUSTED ||
      !details.ParseFromString(status.error_details()))
    return {};
  google::rpc::RetryInfo retry;
  for (const auto& detail : details.details()) {
    if (detail.UnpackTo(&retry)) {
      return milliseconds(
          google::protobuf::util::TimeUtil::DurationToMilliseconds(retry.retry_delay()));
    }
  }
  return {};
}

void Retries::progressed() {
  refused_ = 0;
  waited_ = milliseconds(0);
}

std::optional<milliseconds> Retries::pause(const grpc::Status& status) {
  const auto delay = retry_delay(status);
  if (!delay) return {};
  ++refused_;
  const int doublings = std::clamp(refused_ - kFirstDoubled, 0, 10);
  const milliseconds pause =
      scattered(std::max(*delay, std::min(*delay * (1 << doublings), kLongestPause)));
  const bool is_late = deadline_ && std::chrono::system_clock::now() + pause > *deadline_;
  if (is_late || waited_ + pause > kLongest) return {};
  waited_ += pause;
  return pause;
}

bool Retries::wait(const grpc::Status& status, const std::stop_token& stop) {
  const auto length = pause(status);
  return length && sleep_unless_stopped(*length, stop);
}

}  // namespace sightline::client::calls
