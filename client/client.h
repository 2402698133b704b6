// A connection to a Sightline server: spans in, spans out.
#pragma once

#if __cplusplus < 202002L
#error "The client of Sightline needs C++20: compile with -std=c++20 or later"
#endif

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "client/backup.h"
#include "client/cast_options.h"
#include "client/mesh_blob.h"
#include "client/points.h"
#include "client/prefetch.h"
#include "client/ray_generator.h"
#include "client/result.h"
#include "client/scene_info.h"
#include "client/shared_memory.h"
#include "client/update.h"
#include "client/update_stream.h"

namespace sightline::client::calls {
struct Connection;
}

namespace sightline::client {

class AsyncClient;

struct ClientOptions {
  /// How long a call may take before it fails with kDeadlineExceeded. If not set: one minute for
  /// calls that send neither rays nor meshes, and no limit for the others.
  std::optional<std::chrono::milliseconds> timeout{};

  /// PEM files. With `tls_ca` the connection is encrypted, and the server needs a certificate of
  /// its name that one of these has signed. Empty: no encryption.
  std::filesystem::path tls_ca = {};
  /// The certificate of this client and its key, for servers that ask for one. May be empty.
  std::filesystem::path tls_cert = {}, tls_key = {};
  /// Sent with every call; visible ASCII. Empty: none.
  std::string token = {};
  /// Otherwise clients of this process with the same endpoint and options may share a connection.
  bool own_connection = false;
  /// Whether rays and answers go through memory that this client and the server share, where the
  /// server is on this machine and offers it. Client::transport() tells which it is.
  bool use_segments = true;
};

/// What updates, and rays or points that were cast after them, came to.
struct AppliedCast {
  Applied applied;
  /// At the revision that the updates made; at a newer one only if they were `replayed`, and that
  /// revision is not kept any more.
  CastReport cast;
};

/// Scenes are named projects/{project}/scenes/{scene}. Errors have the server's code, message and
/// reason, or kUnavailable if the server cannot be reached. Calls that only read are retried before
/// they fail with kUnavailable. Threads: any, for every member. Members wait for their answers;
/// AsyncClient (client/async_client.h) makes calls that do not.
class Client {
 public:
  /// `endpoint` is HOST:PORT, unix:PATH, or HOST:PORT,HOST:PORT... of replicas. The first call
  /// makes the connection, and a later call reconnects if it broke. Calls go to replicas in
  /// turn, and to all addresses of a host's name; those that do not serve are left out. With TLS
  /// all replicas of a list need a certificate for the name of the first. Errors: kInvalidArgument,
  /// an endpoint of another form, a file that cannot be read, or a bad token; kUnauthenticated, a
  /// token that would be sent to another machine without encryption; kUnavailable, a host of a list
  /// without an address.
  static Result<Client> connect(const std::string& endpoint, const ClientOptions& options = {});

  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;
  ~Client();

  Result<ServerInfo> server_info() const;

  /// How large casts go to the server, as far as is known: that is found by the first cast of 1,024
  /// rays or more, or by share_memory(). Casts give the same answers either way: what does not work
  /// through shared memory is sent in messages, and tried again later.
  TransportChoice transport() const;
  /// Memory for the columns of casts, which are then not copied; see SharedMemory. Where the server
  /// offers none, it is ordinary memory, and says so. The server counts the bytes as memory that it
  /// holds, until the last array and SharedMemory is gone. Errors: kResourceExhausted, there is not
  /// as much memory, or 0 bytes are asked for.
  Result<SharedMemory> share_memory(std::size_t bytes) const;

  /// Errors: kAlreadyExists.
  Result<SceneInfo> create_scene(const std::string& scene, UpAxis up_axis = UpAxis::kUnknown,
                                 double meters_per_unit = 0) const;
  /// Errors: kNotFound; kCancelled, a stop was requested.
  Result<SceneInfo> get_scene(const std::string& scene, const std::stop_token& stop = {}) const;
  /// All scenes of projects/{project}, or of all projects with "projects/-", by name.
  Result<std::vector<SceneInfo>> list_scenes(const std::string& project) const;
  Status delete_scene(const std::string& scene) const;

  /// Copies the server's scenes to a directory that is empty or missing, each as it is when its
  /// turn comes. Writers go on. Errors: kFailedPrecondition (the directory is not empty, or the
  /// server keeps scenes in memory only), kInvalidArgument (a file cannot be written), kNotFound.
  Result<std::vector<BackupScene>> backup(const std::filesystem::path& directory,
                                          const BackupOptions& options = {}) const;
  /// Puts the scenes of a backup in the place of those with the same names, or makes them. After an
  /// error some may be restored. Errors: kDataLoss (the backup is not whole), kOutOfRange (it does
  /// not have the revision), kNotFound (nor the scene), kInvalidArgument (a file cannot be read),
  /// kFailedPrecondition (the server keeps scenes in memory only).
  Result<std::vector<RestoredScene>> restore(const std::filesystem::path& directory,
                                             const RestoreOptions& options = {}) const;

  Result<SceneStats> scene_stats(const std::string& scene) const;
  /// Drops the scene's trees, which rays grow again. Returns about the bytes that they took.
  Result<std::uint64_t> cool_scene(const std::string& scene) const;
  /// The mesh that a node has now, as one revision has it. Errors: kNotFound;
  /// kFailedPrecondition (NODE_WITHOUT_MESH); kAborted, it changes faster than it can be read;
  /// kCancelled.
  Result<NodeMesh> read_mesh(const std::string& scene, std::uint64_t node,
                             const std::stop_token& stop = {}) const;
  /// Returns one node per id, in order. A node that does not exist has id 0.
  Result<std::vector<NodeInfo>> get_nodes(const std::string& scene,
                                          std::span<const std::uint64_t> ids,
                                          const Consistency& consistency = {}) const;

  /// Makes a scene of one mesh, which its one node has: "mesh", with the id 1. Uploads the mesh
  /// unless the server has it, and then does what put_scene() does. Numbers are (n, 3), copied into
  /// rows. Errors: kInvalidArgument, numbers that are not 3 each, no faces, or a face with a vertex
  /// that does not exist (one of kNoVertex alone is never hit); kAlreadyExists, unless
  /// options.replace, before the mesh is sent; kResourceExhausted, a mesh beyond the server's
  /// limits; those of put_scene().
  Result<SceneInfo> import_arrays(const std::string& scene, std::span<const Vertex> vertices,
                                  std::span<const Face> faces,
                                  const PutSceneOptions& options = {}) const;
  Result<SceneInfo> import_arrays(const std::string& scene, std::span<const float> vertices,
                                  std::span<const std::uint32_t> faces,
                                  const PutSceneOptions& options = {}) const;

  /// Makes a scene with all its nodes in one step, as one revision. Others find the whole scene,
  /// and before it none, or the one that it replaces; after an error, too. If the connection breaks
  /// while the server makes the scene, it is not known which of both they find. The aliases of
  /// `nodes` are negative; the i-th gets the id i + 1. Errors: kAlreadyExists, unless
  /// options.replace; kFailedPrecondition, meshes that were not uploaded; kCancelled; those of the
  /// nodes.
  Result<SceneInfo> put_scene(const std::string& scene, std::span<const PutNode> nodes,
                              const PutSceneOptions& options = {}) const;

  /// Applies all updates or none, and makes one revision, even if the request has to be sent
  /// several times. Errors: kResourceExhausted if the updates do not fit one message of 1 MiB;
  /// kAborted if the scene is not at the expected revision; those of the updates.
  Result<Applied> apply(const std::string& scene, std::span<const Update> updates,
                        const ApplyOptions& options = {}) const;
  /// Applies any number of updates. Each message of them makes one revision. Aliases hold across
  /// all messages. After an error, earlier messages stay applied.
  Result<Applied> apply_in_batches(const std::string& scene, std::span<const Update> updates,
                                   const ApplyOptions& options = {}) const;

  /// Opens a stream of updates by the producer of this name, [A-Za-z0-9._-]{1,64}. The stream
  /// continues where the last stream of that name in this scene ended. If that stream is still
  /// open, this one replaces it. Errors: kDeadlineExceeded, not opened within the client's timeout.
  Result<UpdateStream> open_update_stream(const std::string& scene, const std::string& producer,
                                          const UpdateStreamOptions& options = {}) const;
  /// Passes every revision after `start` (default: the current one) to the sink, until the sink
  /// returns false or a stop is requested (kCancelled). Opens the call again after the connection
  /// breaks. Errors: kOutOfRange, a needed revision is not kept any more: read the scene, then
  /// watch from its revision.
  Status watch(const std::string& scene, std::optional<std::uint64_t> start,
               const SceneChangeSink& sink, const std::stop_token& stop = {}) const;

  /// The digests of the meshes that the server does not have.
  Result<std::vector<std::string>> missing_meshes(std::span<const std::string> digests) const;
  /// Uploads a mesh under its digest. Continues an earlier upload where it stopped, also after the
  /// connection breaks. `stop` cancels the upload.
  Status upload_mesh(const MeshBlob& mesh, const std::string& digest,
                     const UploadProgress& progress = {}, const std::stop_token& stop = {}) const;

  /// Builds all trees of the scene, or of the nodes in the options, before rays come. Errors:
  /// kResourceExhausted (TOO_MANY_PREFETCHES) if the server already runs as many prefetches as it
  /// accepts.
  Result<PrefetchReport> prefetch(const std::string& scene, const PrefetchOptions& options = {},
                                  const PrefetchProgress& progress = {}) const;
  /// Builds the cells that a cast of these rays would build, and returns no hits. Accepts any
  /// number of rays, and makes one call for each kRaysPerMessage of them. The report has the
  /// revision of the last call. Errors: as prefetch().
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
  Result<PrefetchReport> prefetch_rays(const std::string& scene, const RayGenerator& generator,
                                       const PrefetchOptions& options = {},
                                       const PrefetchProgress& progress = {}) const;
  /// As prefetch_rays(), for what nearest() of these points would build. The report counts points
  /// as rays.
  Result<PrefetchReport> prefetch_points(const std::string& scene,
                                         const PointColumns<const double>& points,
                                         const PrefetchOptions& options = {},
                                         const PrefetchProgress& progress = {}) const;
  Result<PrefetchReport> prefetch_points(const std::string& scene,
                                         const PointColumns<const float>& points,
                                         const PrefetchOptions& options = {},
                                         const PrefetchProgress& progress = {}) const;
  Result<PrefetchReport> prefetch_points(const std::string& scene,
                                         const PointSource<double>& source, PointShape shape,
                                         const PrefetchOptions& options = {},
                                         const PrefetchProgress& progress = {}) const;
  Result<PrefetchReport> prefetch_points(const std::string& scene, const PointSource<float>& source,
                                         PointShape shape, const PrefetchOptions& options = {},
                                         const PrefetchProgress& progress = {}) const;
  Result<PrefetchReport> prefetch_points(const std::string& scene, const PointGrid& grid,
                                         const PrefetchOptions& options = {},
                                         const PrefetchProgress& progress = {}) const;

  /// Casts one batch of rays in one message at one revision. Fills the columns of `hits` that are
  /// not empty, one row per ray. The server limits the number of rays in a message; cast_stream
  /// takes more, and so does this where rays go through shared memory. Errors: kInvalidArgument if
  /// columns disagree in length, and for kAll, whose answers do not have one row per ray.
  Result<CastReport> cast(const std::string& scene, const RayColumns<const double>& rays,
                          const HitColumns& hits, const CastOptions& options = {}) const;
  Result<CastReport> cast(const std::string& scene, const RayColumns<const float>& rays,
                          const HitColumns& hits, const CastOptions& options = {}) const;

  /// Applies updates as apply() does, and then casts rays as cast() does, in one call at the
  /// revision that they make. Sent several times, the updates are applied once. If the request is
  /// refused, nothing was applied; after any other error they may be, and the same call with the
  /// same ApplyOptions::request_id tells. `options.root` and `exclude` are ids, which may be of
  /// nodes that the updates put or delete. Errors: as apply() and cast(); kInvalidArgument for a
  /// consistency; kUnimplemented, the server is of an earlier version, and nothing was applied.
  Result<AppliedCast> apply_and_cast(const std::string& scene, std::span<const Update> updates,
                                     const RayColumns<const double>& rays, const HitColumns& hits,
                                     const CastOptions& options = {},
                                     const ApplyOptions& apply_options = {}) const;
  Result<AppliedCast> apply_and_cast(const std::string& scene, std::span<const Update> updates,
                                     const RayColumns<const float>& rays, const HitColumns& hits,
                                     const CastOptions& options = {},
                                     const ApplyOptions& apply_options = {}) const;

  /// Casts any number of rays over one stream, all at one revision, and writes the answers to
  /// `hits`. A message has kRaysPerMessage rays, more through shared memory, and kMessagesInFlight
  /// messages are sent before the first is answered. After an error the rows of `hits` are partly
  /// written.
  Result<CastReport> cast_stream(const std::string& scene, const RayColumns<const double>& rays,
                                 const HitColumns& hits, const CastOptions& options = {}) const;
  Result<CastReport> cast_stream(const std::string& scene, const RayColumns<const float>& rays,
                                 const HitColumns& hits, const CastOptions& options = {}) const;
  /// Casts in bounded memory: `source` gives the rays and `sink` takes the answers while the cast
  /// runs.
  Result<CastReport> cast_stream(const std::string& scene, const RaySource<double>& source,
                                 RayShape shape, HitFields fields, const HitSink& sink,
                                 const CastOptions& options = {}) const;
  Result<CastReport> cast_stream(const std::string& scene, const RaySource<float>& source,
                                 RayShape shape, HitFields fields, const HitSink& sink,
                                 const CastOptions& options = {}) const;

  /// Casts any number of rays that the server makes, so that none are sent. Errors: as make_rays().
  Result<CastReport> cast_stream(const std::string& scene, const RayGenerator& generator,
                                 const HitColumns& hits, const CastOptions& options = {}) const;
  Result<CastReport> cast_stream(const std::string& scene, const RayGenerator& generator,
                                 HitFields fields, const HitSink& sink,
                                 const CastOptions& options = {}) const;

  /// Returns every hit of any number of rays, over the same kind of stream. The kind is kAll,
  /// whatever the options say. `fields` are the fields wanted in addition to offsets and `hit`.
  Result<AllHits> cast_all(const std::string& scene, const RayColumns<const double>& rays,
                           HitFields fields, const CastOptions& options = {}) const;
  Result<AllHits> cast_all(const std::string& scene, const RayColumns<const float>& rays,
                           HitFields fields, const CastOptions& options = {}) const;

  /// Finds the face nearest to each point of one batch, in one message at one revision. Fills the
  /// columns of `hits` that are not empty, one row per point: `t` is the distance, `position` the
  /// nearest point of the face and `barycentric` its weights. Every kind of query counts the faces
  /// within a point's max_distance. `options` are those of casts, but for `culling`, which must be
  /// kNone. `signed_distance`, `inside` and `votes` tell on which side of the surfaces the points
  /// are, whatever their max_distance; if only the last two are asked, no distance is computed.
  /// Errors: as cast(); and kInvalidArgument for sides with another kind than kClosest, and for
  /// side options that are out of range, or without a column of theirs.
  Result<CastReport> nearest(const std::string& scene, const PointColumns<const double>& points,
                             const HitColumns& hits, const CastOptions& options = {}) const;
  Result<CastReport> nearest(const std::string& scene, const PointColumns<const float>& points,
                             const HitColumns& hits, const CastOptions& options = {}) const;

  /// As apply_and_cast(), with nearest() in the place of cast().
  Result<AppliedCast> apply_and_nearest(const std::string& scene, std::span<const Update> updates,
                                        const PointColumns<const double>& points,
                                        const HitColumns& hits, const CastOptions& options = {},
                                        const ApplyOptions& apply_options = {}) const;
  Result<AppliedCast> apply_and_nearest(const std::string& scene, std::span<const Update> updates,
                                        const PointColumns<const float>& points,
                                        const HitColumns& hits, const CastOptions& options = {},
                                        const ApplyOptions& apply_options = {}) const;

  /// As nearest(), for any number of points, over one stream as that of cast_stream().
  Result<CastReport> nearest_stream(const std::string& scene,
                                    const PointColumns<const double>& points,
                                    const HitColumns& hits, const CastOptions& options = {}) const;
  Result<CastReport> nearest_stream(const std::string& scene,
                                    const PointColumns<const float>& points, const HitColumns& hits,
                                    const CastOptions& options = {}) const;
  Result<CastReport> nearest_stream(const std::string& scene, const PointSource<double>& source,
                                    PointShape shape, HitFields fields, const HitSink& sink,
                                    const CastOptions& options = {}) const;
  Result<CastReport> nearest_stream(const std::string& scene, const PointSource<float>& source,
                                    PointShape shape, HitFields fields, const HitSink& sink,
                                    const CastOptions& options = {}) const;
  /// For points that the server makes, so that none are sent. Errors: as make_points().
  Result<CastReport> nearest_stream(const std::string& scene, const PointGrid& grid,
                                    const HitColumns& hits, const CastOptions& options = {}) const;
  Result<CastReport> nearest_stream(const std::string& scene, const PointGrid& grid,
                                    HitFields fields, const HitSink& sink,
                                    const CastOptions& options = {}) const;

  /// Returns faces by their distance for any number of points: with options.max_hits k, the k
  /// nearest; with a max_distance, those that a ball around the point meets. Otherwise as
  /// cast_all().
  Result<AllHits> nearest_all(const std::string& scene, const PointColumns<const double>& points,
                              HitFields fields, const CastOptions& options = {}) const;
  Result<AllHits> nearest_all(const std::string& scene, const PointColumns<const float>& points,
                              HitFields fields, const CastOptions& options = {}) const;

 private:
  friend class AsyncClient;
  explicit Client(std::shared_ptr<const calls::Connection> connection);
  std::shared_ptr<const calls::Connection> connection_;
};

}  // namespace sightline::client
