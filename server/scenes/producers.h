// Who streams updates into a scene, and how far each has come.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/node.h"

namespace sightline::server::scenes {

inline constexpr std::size_t kMaxProducerName = 64;  ///< Bytes.
inline constexpr std::size_t kMaxProducers = 4096;   ///< Names a scene.

/// Lives as long as its scene.
struct Producer {
  /// The ids that a batch has put.
  struct Put {
    std::uint64_t sequence = 0;
    std::vector<scenegraph::model::NodeId> nodes;
  };

  /// Of the batch after the last, which was applied or rejected; in the scene's turn.
  void commit(std::uint64_t sequence, const std::vector<scenegraph::model::NodeId>& put);

  std::uint64_t last_committed = 0;        ///< Sequence. In the scene's turn, as the next.
  std::deque<Put> put;                     ///< Of the last kPutsKept batches at most.
  std::atomic<const void*> call{nullptr};  ///< That speaks for it. Written in turn, read by any.
};

inline constexpr std::uint64_t kPutsKept = 16;  ///< As many as a call has on their way.
inline constexpr std::size_t kPutIdsKept = 65536;

/// In the scene's turn.
class Producers {
 public:
  explicit Producers(std::size_t limit = kMaxProducers) : limit_(limit) {}

  /// The producer of this name, known or new. Errors: kResourceExhausted, too many names.
  Result<Producer*> open(const std::string& name);

 private:
  const std::size_t limit_;
  std::map<std::string, Producer> producers_;
};

/// Errors: kInvalidArgument unless it matches [A-Za-z0-9._-]{1,64}.
Status check_producer_name(std::string_view name);

}  // namespace sightline::server::scenes
