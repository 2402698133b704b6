// What a scene records of its writers, so that a request that is sent again is applied once.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/node.h"
#include "scenegraph/scene.h"
#include "server/scenes/history.h"
#include "server/scenes/record_chunks.h"

namespace sightline::server::scenes {

inline constexpr std::size_t kMaxRequestId = 64;  ///< Bytes.

struct AnswerLimits {
  std::size_t answers = 1024;
  std::size_t nodes = std::size_t{1}
                      << 20;  ///< Node ids in all answers. The newest answer is always kept.
};

/// The last answers to requests with a request id: a request that is sent again gets its first
/// answer. Threads: one at a time.
class RequestAnswers {
 public:
  /// Answers are charged to `memory`.
  explicit RequestAnswers(exec::MemoryAccount& memory, AnswerLimits limits = {})
      : records_(memory),
        entries_({.entries = limits.answers, .weight = limits.nodes, .min_entries = 1}, memory) {}

  /// The revision and the nodes of the answer to an earlier request of this id, if there is one.
  /// `content` is a digest of the request. Errors: kInvalidArgument if the earlier request had
  /// another content. Cost: a look at the digest of each id.
  Result<std::optional<scenegraph::Applied>> find(std::string_view id, std::uint64_t content) const;
  bool knows(std::string_view id) const { return find_entry(id) != nullptr; }

  struct Entry {
    std::uint64_t digest = 0;  ///< The id's.
    Record record;             ///< No bytes: nothing to keep.
    std::size_t nodes = 0;
  };
  /// Makes an entry, and reserves memory to add it and `waiting` others that were made before.
  /// find() must not know the id. Throws std::bad_alloc, and then nothing has changed.
  Entry prepare(std::string_view id, std::uint64_t content, const scenegraph::Applied& answer,
                std::size_t waiting = 0);
  /// Adds an entry. The entry may be empty: then nothing happens.
  void retain(Entry entry) noexcept;

 private:
  const Entry* find_entry(std::string_view id) const;

  RecordChunks records_;
  History<Entry> entries_;  // weight: node ids
};

/// The error (kInvalidArgument) of an id that stands for another request, which made this revision.
Error request_id_reused(const std::string& id, std::uint64_t revision);

/// Errors: kInvalidArgument beyond kMaxRequestId.
Status check_request_id(std::string_view id);

inline constexpr std::size_t kMaxProducerName = 64;  ///< Bytes.
inline constexpr std::size_t kMaxProducers = 4096;   ///< For each scene.

/// Batches of a producer whose put nodes are kept: as many as a call may have in flight.
inline constexpr std::size_t kPutsKept = 16;
inline constexpr std::size_t kPutIdsKept = 65536;  ///< Node ids in all of them.
inline constexpr HistoryLimits kPutLimits{.entries = kPutsKept, .weight = kPutIdsKept};

/// About the bytes of a producer without its name and its batches.
inline constexpr std::uint64_t kBytesPerProducer = 448;

/// A writer that streams numbered batches, and what is kept of the last ones. A batch that is sent
/// again is known by its number. Lives as long as its scene. Used on the scene's write queue,
/// except for `call`.
struct Producer {
  /// The ids of the nodes that a batch has put.
  struct Put {
    std::uint64_t sequence = 0;
    std::vector<scenegraph::model::NodeId> nodes;  ///< Empty for a batch that put none.
    exec::MemoryAccount::Charge charge = {};
  };

  Producer(std::string of, exec::MemoryAccount& memory, exec::MemoryAccount::Charge held)
      : name(std::move(of)), charge(std::move(held)), put(kPutLimits, memory) {}

  /// Records the next batch, which was applied or rejected. Does not throw after
  /// put.reserve_more().
  void commit(Put batch);

  const std::string name;
  const exec::MemoryAccount::Charge charge;  ///< Without `put`.
  std::uint64_t last_committed = 0;          ///< Sequence number.
  History<Put> put;                          ///< One entry for each batch.
  /// The call that owns the producer now. Written on the write queue, read by any thread.
  std::atomic<const void*> call{nullptr};
};

/// The producers of one scene, by name. Used on the scene's write queue.
class Producers {
 public:
  /// Names are charged to `memory`, which outlives this object.
  explicit Producers(exec::MemoryAccount& memory, std::size_t limit = kMaxProducers)
      : memory_(memory), limit_(limit) {}

  /// Finds the producer of this name or adds it. Errors: kResourceExhausted (too many names, or the
  /// memory budget).
  Result<Producer*> open(const std::string& name);

 private:
  exec::MemoryAccount& memory_;
  const std::size_t limit_;
  std::map<std::string, Producer> producers_;
};

/// Errors: kInvalidArgument unless it matches [A-Za-z0-9._-]{1,64}.
Status check_producer_name(std::string_view name);

}  // namespace sightline::server::scenes
