// The time of a cast of one ray beside that of the least call there can be.
#pragma once

#include <vector>

#include "proto/result.h"
#include "tests/bench/remote/peer_process.h"
#include "tests/bench/remote/remote_rays.h"
#include "tests/bench/verbs/report.h"

namespace sightline::bench {

/// Calls of one ray each to the server, which has the scene of upload(), and to an echo service of
/// the same messages, in turns: a row with both ends on one processor, and one with an end on each
/// of two. A process that has one processor has the first row alone. Pins all threads of this
/// process meanwhile. Errors: kFailedPrecondition.
Result<std::vector<Row>> measure_latency(const PeerProcess& server, const RemoteRays& rays);

}  // namespace sightline::bench
