// The producers that stream updates into a scene, and the last batch of each.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/node.h"
#include "server/scenes/history.h"

namespace sightline::server::scenes {

inline constexpr std::size_t kMaxProducerName = 64;  ///< Bytes.
inline constexpr std::size_t kMaxProducers = 4096;   ///< For each scene.

/// Batches of a producer whose put nodes are kept: as many as a call may have in flight.
inline constexpr std::size_t kPutsKept = 16;
inline constexpr std::size_t kPutIdsKept = 65536;  ///< Node ids in all of them.

/// Lives as long as its scene. Used on the scene's write queue, except for `call`.
struct Producer {
  /// The ids of the nodes that a batch has put.
  struct Put {
    std::uint64_t sequence = 0;
    std::vector<scenegraph::model::NodeId> nodes;  ///< Empty for a batch that put none.
  };

  /// Records the next batch, which was applied or rejected.
  void commit(std::uint64_t sequence, const std::vector<scenegraph::model::NodeId>& nodes);

  std::uint64_t last_committed = 0;                                 ///< Sequence number.
  History<Put> put{{.entries = kPutsKept, .weight = kPutIdsKept}};  ///< One entry for each batch.
  /// The call that owns the producer now. Written on the write queue, read by any thread.
  std::atomic<const void*> call{nullptr};
};

/// Used on the scene's write queue.
class Producers {
 public:
  explicit Producers(std::size_t limit = kMaxProducers) : limit_(limit) {}

  /// Finds the producer of this name or adds it. Errors: kResourceExhausted (too many names).
  Result<Producer*> open(const std::string& name);

 private:
  const std::size_t limit_;
  std::map<std::string, Producer> producers_;
};

/// Errors: kInvalidArgument unless it matches [A-Za-z0-9._-]{1,64}.
Status check_producer_name(std::string_view name);

}  // namespace sightline::server::scenes
