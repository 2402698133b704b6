// The calls of a client that return at once and complete later.
#pragma once

#include <memory>
#include <span>
#include <stop_token>
#include <string>

#include "client/async_call.h"
#include "client/client.h"

namespace sightline::client {

/// Makes calls over the connection of a Client, any number at a time. Each call does what the
/// member of Client of the same name does, with the same deadlines, retries, errors and reports.
/// A stop that is requested by the token in the options ends the call with kCancelled; it completes
/// then, too.
///
/// A member copies its rays, points, updates and options before it returns. The arrays of `hits`
/// must live until the call has completed: a thread of gRPC fills them before the completion runs.
/// Calls share the connection: they complete even if the Client and the AsyncClient are destroyed
/// before. Threads: any, for every member.
///
/// Streams are not here. Client::cast_stream() and the others block the thread that takes their
/// answers, which std::async() can provide. UpdateStream sends without waiting (try_send) and
/// reports by its own callbacks.
class AsyncClient {
 public:
  /// `executor` runs the completions of all calls.
  explicit AsyncClient(const Client& client, Executor executor = {});

  AsyncCall<CastReport> cast(const std::string& scene, const RayColumns<const double>& rays,
                             const HitColumns& hits, const CastOptions& options = {}) const;
  AsyncCall<CastReport> cast(const std::string& scene, const RayColumns<const float>& rays,
                             const HitColumns& hits, const CastOptions& options = {}) const;

  AsyncCall<CastReport> nearest(const std::string& scene, const PointColumns<const double>& points,
                                const HitColumns& hits, const CastOptions& options = {}) const;
  AsyncCall<CastReport> nearest(const std::string& scene, const PointColumns<const float>& points,
                                const HitColumns& hits, const CastOptions& options = {}) const;

  /// Calls that are under way together may be applied in any order: begin an update that needs
  /// another one when that has completed, or send them over an UpdateStream.
  AsyncCall<Applied> apply(const std::string& scene, std::span<const Update> updates,
                           const ApplyOptions& options = {}) const;

  /// Runs `progress` on threads of gRPC, one report after the other, whatever the executor is. It
  /// must not throw.
  AsyncCall<PrefetchReport> prefetch(const std::string& scene, const PrefetchOptions& options = {},
                                     PrefetchProgress progress = {}) const;

  AsyncCall<SceneInfo> get_scene(const std::string& scene, const std::stop_token& stop = {}) const;
  AsyncCall<SceneStats> scene_stats(const std::string& scene,
                                    const std::stop_token& stop = {}) const;
  AsyncCall<ServerInfo> server_info(const std::stop_token& stop = {}) const;

 private:
  std::shared_ptr<const calls::Connection> connection_;
  Executor executor_;
};

}  // namespace sightline::client
