// Where a scene is kept beyond the end of the process.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/update.h"
#include "scenegraph/scene.h"
#include "server/scenes/names.h"
#include "server/scenes/replica.h"
#include "server/scenes/scene_info.h"
#include "server/store/store.h"

namespace sightline::server::scenes {

/// How a write is kept when it is acknowledged.
enum class Durability : std::uint8_t {
  kRelaxed,    ///< In memory. It may be lost with the process.
  kCommitted,  ///< On disk.
};

/// A numbered batch of a producer.
struct ProducerBatch {
  std::uint64_t sequence = 0;
  std::vector<scenegraph::model::NodeId> nodes;  ///< The nodes that it put, in order.
};

/// What is kept of a write.
struct JournalEntry {
  std::uint64_t expected = 0;  ///< The newest revision before it.
  /// The result of Journal::encode(); these updates make the next revision. Nothing: a rejected
  /// batch.
  std::optional<std::string> updates;
  std::vector<std::string> mesh_digests;         ///< Digests of the meshes that the updates put.
  std::vector<scenegraph::model::NodeId> nodes;  ///< The nodes that the updates put, in order.
  std::string request_id;                        ///< Empty: none.
  std::uint64_t content = 0;                     ///< Digest of the request.
  std::string producer;                          ///< Empty: none.
  std::vector<ProducerBatch> batches;            ///< The producer's batches in the write.
  std::shared_ptr<store::BatchOutcome> outcome = {};      ///< See store::Batch::outcome.
  std::shared_ptr<const store::BatchOutcome> after = {};  ///< See store::Batch::after.
};

/// The answer to a request with a request id.
struct KeptAnswer {
  std::uint64_t content = 0;  ///< Digest of the request.
  scenegraph::Applied applied;
};

/// A producer's progress.
struct KeptProducer {
  std::uint64_t last_committed = 0;   ///< Sequence number.
  std::vector<ProducerBatch> recent;  ///< The last batches, oldest first.
};

/// What a journal keeps of a scene, in this order: one base, all batches after it, answers,
/// producers. An error ends the load.
class JournalReader {
 public:
  virtual ~JournalReader() = default;
  virtual Status base(scenegraph::SceneContent content) = 0;
  /// `updates`: as they were given to Scene::apply; `nodes`: the ids of those that they put.
  virtual Status batch(std::uint64_t revision, std::vector<scenegraph::model::Update> updates,
                       const std::vector<scenegraph::model::NodeId>& nodes) = 0;
  /// Answers come oldest first.
  virtual Status answer(const std::string& request_id, std::uint64_t content,
                        const scenegraph::Applied& applied) = 0;
  /// `recent`: the last batches, oldest first.
  virtual Status producer(const std::string& name, std::uint64_t last_committed,
                          std::vector<ProducerBatch> recent) = 0;
};

/// The journal of one scene. Threads: any, for every member.
class Journal {
 public:
  using Done = std::function<void(const Status&)>;

  virtual ~Journal() = default;

  /// Reads all that is kept. Errors: kDataLoss, naming what is corrupt; kResourceExhausted, if the
  /// memory budget has no room for it; those of `into`.
  virtual Status load(JournalReader& into) = 0;

  /// Reads the batches after `revision` only. Errors: as load(), and kOutOfRange
  /// (REVISION_NOT_KEPT: they are not kept any more), kNotFound (the scene was removed).
  virtual Status follow(std::uint64_t revision, JournalReader& into) = 0;
  /// What is kept of a request. Nothing: it is not known.
  virtual Result<std::optional<KeptAnswer>> answer(const std::string& request_id) = 0;
  /// What is kept of a producer. Nothing: it is not known.
  virtual Result<std::optional<KeptProducer>> producer(const std::string& name) = 0;

  virtual std::string encode(const std::vector<scenegraph::model::Update>& updates,
                             const std::vector<scenegraph::model::NodeId>& nodes) const = 0;
  /// The updates that encode() was given. Errors: as load().
  virtual Result<std::vector<scenegraph::model::Update>> decode(const std::string& updates) = 0;
  /// Keeps the entry if `expected` is the last revision that is kept. Calls done() once, on any
  /// thread, in the order of the calls. Returns an error, and never calls it, if it takes no more.
  virtual Status append(const JournalEntry& entry, Done done) = 0;

  /// Called after a revision was published, on the write queue: from time to time the journal
  /// writes all nodes down. `oldest`: the oldest revision that can be read. Returns soon.
  virtual void published(const scenegraph::SceneState& newest, std::uint64_t oldest) noexcept = 0;

  /// Drops all that is kept of the scene. Waits for the disk. Errors: kNotFound, kUnavailable.
  virtual Status remove() = 0;
};

/// How a scene is kept beyond the process. Without a journal: not at all.
struct KeptScene {
  std::shared_ptr<Journal> journal = nullptr;
  std::uint64_t incarnation = new_incarnation();
  /// The newest revision of the journal, which load() must read first. Nothing: it holds none.
  std::optional<std::uint64_t> unread = {};
  /// The catalog's number of the scene. Later scenes have greater ones.
  store::SceneId number = 0;
  /// Set if other servers write to the journal, too; else null.
  std::shared_ptr<Replica> replica = nullptr;
  /// What its nodes took when they were read the last time, as far as that went. 0: not known.
  std::uint64_t node_bytes = 0;
};

/// The catalog of the scenes that outlive the process. Threads: any, for every member.
class SceneCatalog {
 public:
  virtual ~SceneCatalog() = default;

  /// Waits for the disk. Errors: kAlreadyExists, kResourceExhausted, kUnavailable.
  virtual Result<KeptScene> create(const SceneInfo& info) = 0;

  /// Keeps a scene with these nodes; with `replace` in place of the one of its name, if there is
  /// one. Waits for the disk. Errors: as create().
  virtual Result<KeptScene> restore(const SceneInfo& info, const scenegraph::SceneState& state,
                                    bool replace) = 0;

  struct Found {
    SceneInfo info;
    KeptScene kept;
  };
  /// All scenes that are kept.
  virtual Result<std::vector<Found>> find_all() = 0;
  /// The scene of this name. Nothing: there is none.
  virtual Result<std::optional<Found>> find(const std::string& name) = 0;
  /// The replica if other servers keep scenes in the same place; else null.
  virtual Replica* replica() = 0;
};

}  // namespace sightline::server::scenes
