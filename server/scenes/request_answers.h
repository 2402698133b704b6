// The last answers to requests with a request id: a request that is sent again gets its first
// answer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "accel/result.h"
#include "scenegraph/scene.h"
#include "server/scenes/history.h"

namespace sightline::server::scenes {

inline constexpr std::size_t kMaxRequestId = 64;  ///< Bytes.

struct AnswerLimits {
  std::size_t answers = 1024;
  std::size_t nodes = std::size_t{1}
                      << 20;  ///< Node ids in all answers. The newest answer is always kept.
};

/// Threads: one at a time.
class RequestAnswers {
 public:
  explicit RequestAnswers(AnswerLimits limits = {})
      : ids_({.entries = limits.answers, .weight = limits.nodes, .min_entries = 1}) {}

  /// The answer to an earlier request of this id, or null. `content` is a digest of the request.
  /// Errors: kInvalidArgument if the earlier request had another content.
  Result<const scenegraph::Applied*> find(const std::string& id, std::uint64_t content) const;
  /// Adds an answer. find() must not know the id.
  void retain(const std::string& id, std::uint64_t content, scenegraph::Applied answer);

 private:
  struct Kept {
    std::uint64_t content = 0;
    scenegraph::Applied answer;
  };

  std::unordered_map<std::string, Kept> answers_;
  History<std::string> ids_;  // keys of answers_; weight: node ids of the answer
};

/// Errors: kInvalidArgument beyond kMaxRequestId.
Status check_request_id(std::string_view id);

}  // namespace sightline::server::scenes
