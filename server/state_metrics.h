// Metrics of what the server holds now.
#pragma once

#include <optional>

#include "server/durable/store_follower.h"
#include "server/exec/admission.h"
#include "server/exec/memory_account.h"
#include "server/exec/quotas.h"
#include "server/exec/unread_replies.h"
#include "server/metrics/samples.h"
#include "server/net/ended_connections.h"
#include "server/scenes/reclaim.h"
#include "server/scenes/scene_store.h"
#include "server/security/tls.h"
#include "server/segments/segments.h"
#include "server/store/store.h"

namespace sightline::server {

/// The parts that are asked. All outlive the object.
struct StateMetrics {
  const exec::MemoryAccount& memory;
  const exec::Admission& admission;
  const exec::UnreadReplies& unread;
  const exec::Quotas& quotas;
  const segments::Segments& segments;
  const scenes::SceneStore& scenes;
  const scenes::Reclaimer& reclaimer;
  const store::Store* store = nullptr;  ///< Null: scenes are in memory only.
  /// Nothing: no other server uses the store.
  const std::optional<durable::StoreFollower>& follower;
  const net::EndedConnections& ended;
  const security::Tls* tls = nullptr;  ///< Null: no TLS.
  bool per_scene = false;  ///< Also values with a label for the scene. Walks what is built.

  /// Threads: any.
  void add_to(metrics::Samples& samples) const;
};

}  // namespace sightline::server
