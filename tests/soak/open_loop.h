// Calls that are sent when they are due, whether earlier ones have been answered or not.
#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "sightline/v1/query.grpc.pb.h"

namespace sightline::tests::soak {

/// What became of the calls of a stretch of time.
struct Outcome {
  std::vector<double> answered_ms;  ///< From the time that a call was due.
  std::vector<double> refused_ms;   ///< RESOURCE_EXHAUSTED; from the time that it was sent.
  std::vector<std::string> failed;  ///< Messages of other errors.
  double seconds = 0;
  std::size_t in_time = 0;  ///< Answered before the end of the stretch.

  double answered_per_second() const { return static_cast<double>(in_time) / seconds; }
};

/// Sends the same cast over and over. Threads: one caller.
class OpenLoop {
 public:
  /// Each call takes the next of `connections` new connections. Empty token: none is sent.
  OpenLoop(int port, int connections, v1::CastRaysRequest request, std::string token = {});
  ~OpenLoop();

  /// Sends `rate` calls a second, and then waits for all answers.
  Outcome run(double rate, std::chrono::duration<double> time);

 private:
  struct Call;
  struct Tally;

  const v1::CastRaysRequest request_;
  const std::string token_;
  std::vector<std::unique_ptr<v1::RayQueryService::Stub>> stubs_;
};

}  // namespace sightline::tests::soak
