// A connection to a Sightline server: spans in, spans out.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "client/cast_options.h"
#include "client/mesh_blob.h"
#include "client/prefetch.h"
#include "client/result.h"
#include "client/scene_info.h"
#include "client/update.h"
#include "client/update_stream.h"

namespace sightline::client::calls {
struct Connection;
}

namespace sightline::client {

struct ClientOptions {
  /// How long a call may take; then it fails with kDeadlineExceeded. Nothing: a minute for calls
  /// that carry neither rays nor meshes, and no limit for those that do.
  std::optional<std::chrono::milliseconds> timeout;
};

/// Scenes are named projects/{project}/scenes/{scene}. Errors carry the server's code, message and
/// reason; kUnavailable if it cannot be reached. Calls that only read are tried again before they
/// fail so. Threads: any, for every member.
class Client {
 public:
  /// `endpoint` is HOST:PORT, or unix:PATH. The connection is made by the first call, and again
  /// when it breaks. Errors: kInvalidArgument, an endpoint of another form.
  static Result<Client> connect(const std::string& endpoint, const ClientOptions& options = {});

  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;
  ~Client();

  Result<ServerInfo> server_info() const;

  /// Errors: kAlreadyExists.
  Result<SceneInfo> create_scene(const std::string& scene, UpAxis up_axis = UpAxis::kUnknown,
                                 double meters_per_unit = 0) const;
  Result<SceneInfo> get_scene(const std::string& scene) const;
  /// All scenes of projects/{project}, by name.
  Result<std::vector<SceneInfo>> list_scenes(const std::string& project) const;
  Status delete_scene(const std::string& scene) const;
  Result<SceneStats> scene_stats(const std::string& scene) const;
  /// One per id, in order; one that does not exist has id 0.
  Result<std::vector<NodeInfo>> get_nodes(const std::string& scene,
                                          std::span<const std::uint64_t> ids,
                                          const Consistency& consistency = {}) const;

  /// Applies all updates or none, and makes one revision, however often the request has to be sent.
  /// Errors: kResourceExhausted if they do not fit one message of 1 MiB; kAborted if the scene is
  /// not at the revision expected; those of the updates.
  Result<Applied> apply(const std::string& scene, std::span<const Update> updates,
                        const ApplyOptions& options = {}) const;
  /// Any number of updates, in as many revisions as messages. Aliases hold across all of them.
  /// After an error, the messages before it stay applied.
  Result<Applied> apply_in_batches(const std::string& scene, std::span<const Update> updates,
                                   const ApplyOptions& options = {}) const;

  /// Opens a stream of updates by the producer of this name, [A-Za-z0-9._-]{1,64}: it goes on
  /// where the last stream of that name in this scene has ended, and takes it over if it has not.
  /// Errors: kDeadlineExceeded, not opened within the client's timeout.
  Result<UpdateStream> open_update_stream(const std::string& scene, const std::string& producer,
                                          const UpdateStreamOptions& options = {}) const;
  /// Every revision after `start`, by default from now on, until the sink wants no more or a stop
  /// is requested (kCancelled). A broken connection is taken up again. Errors: kOutOfRange, one
  /// that is wanted is not kept any more: read the scene, then watch from its revision.
  Status watch(const std::string& scene, std::optional<std::uint64_t> start,
               const SceneChangeSink& sink, const std::stop_token& stop = {}) const;

  /// Which of these meshes the server does not have.
  Result<std::vector<std::string>> missing_meshes(std::span<const std::string> digests) const;
  /// Uploads a mesh under its digest, from where an upload before has stopped; takes a broken
  /// connection up again. `stop` cancels it.
  Status upload_mesh(const MeshBlob& mesh, const std::string& digest,
                     const UploadProgress& progress = {}, const std::stop_token& stop = {}) const;

  /// Builds all trees of the scene, or of the nodes that the options name, before rays come.
  /// Errors: kResourceExhausted (TOO_MANY_PREFETCHES) where the server is at work on as many as it
  /// takes.
  Result<PrefetchReport> prefetch(const std::string& scene, const PrefetchOptions& options = {},
                                  const PrefetchProgress& progress = {}) const;
  /// Builds what a cast of these rays would, and returns no hits. Any number of rays, a call for
  /// each kRaysPerMessage of them; the revision reported is that of the last. Errors as above.
  Result<PrefetchReport> prefetch_rays(const std::string& scene,
                                       const RayColumns<const double>& rays,
                                       const PrefetchOptions& options = {},
                                       const PrefetchProgress& progress = {}) const;
  Result<PrefetchReport> prefetch_rays(const std::string& scene,
                                       const RayColumns<const float>& rays,
                                       const PrefetchOptions& options = {},
                                       const PrefetchProgress& progress = {}) const;
  Result<PrefetchReport> prefetch_rays(const std::string& scene, const RaySource<double>& source,
                                       RayShape shape, const PrefetchOptions& options = {},
                                       const PrefetchProgress& progress = {}) const;
  Result<PrefetchReport> prefetch_rays(const std::string& scene, const RaySource<float>& source,
                                       RayShape shape, const PrefetchOptions& options = {},
                                       const PrefetchProgress& progress = {}) const;

  /// One batch in one message, answered at one revision into `hits`, whose non-empty columns have a
  /// row a ray. For as many rays as the server takes in a request; more go by cast_stream. Errors:
  /// kInvalidArgument if columns disagree in length, and for kAll, whose answers have no such row.
  Result<CastReport> cast(const std::string& scene, const RayColumns<const double>& rays,
                          const HitColumns& hits, const CastOptions& options = {}) const;
  Result<CastReport> cast(const std::string& scene, const RayColumns<const float>& rays,
                          const HitColumns& hits, const CastOptions& options = {}) const;

  /// Any number of rays over one stream, kRaysPerMessage a message and kMessagesInFlight of them on
  /// their way, all answered at one revision, in place. After an error the rows of `hits` are
  /// partly written.
  Result<CastReport> cast_stream(const std::string& scene, const RayColumns<const double>& rays,
                                 const HitColumns& hits, const CastOptions& options = {}) const;
  Result<CastReport> cast_stream(const std::string& scene, const RayColumns<const float>& rays,
                                 const HitColumns& hits, const CastOptions& options = {}) const;
  /// The same in bounded memory: rays come from `source`, answers go to `sink`, while both run.
  Result<CastReport> cast_stream(const std::string& scene, const RaySource<double>& source,
                                 RayShape shape, HitFields fields, const HitSink& sink,
                                 const CastOptions& options = {}) const;
  Result<CastReport> cast_stream(const std::string& scene, const RaySource<float>& source,
                                 RayShape shape, HitFields fields, const HitSink& sink,
                                 const CastOptions& options = {}) const;

  /// Every hit of any number of rays, by the same kind of stream: kAll, whatever the options say.
  /// `fields` are those wanted beside offsets and `hit`.
  Result<AllHits> cast_all(const std::string& scene, const RayColumns<const double>& rays,
                           HitFields fields, const CastOptions& options = {}) const;
  Result<AllHits> cast_all(const std::string& scene, const RayColumns<const float>& rays,
                           HitFields fields, const CastOptions& options = {}) const;

 private:
  explicit Client(std::unique_ptr<calls::Connection> connection);
  std::unique_ptr<calls::Connection> connection_;
};

}  // namespace sightline::client
