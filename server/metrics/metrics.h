// All metrics of a server.
#pragma once

#include <prometheus/registry.h>

#include <string>

#include "server/metrics/query_metrics.h"
#include "server/metrics/rpc_metrics.h"
#include "server/metrics/samples.h"

namespace sightline::server::metrics {

/// A part of the server that counts something of its own is a member beside the others, made with
/// the registry. Threads: any, for every member.
struct Metrics {
  prometheus::Registry registry;
  RpcMetrics rpcs{registry};
  QueryMetrics queries{registry};
};

/// All metrics, and the samples, in Prometheus' text format.
std::string to_text(const Metrics& metrics, const Samples& samples);

}  // namespace sightline::server::metrics
