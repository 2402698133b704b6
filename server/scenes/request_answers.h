// The last answers to requests that were given an id, for those that are sent again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <unordered_map>

#include "accel/result.h"
#include "scenegraph/scene.h"

namespace sightline::server::scenes {

inline constexpr std::size_t kMaxRequestId = 64;  ///< Bytes.

struct AnswerLimits {
  std::size_t answers = 1024;
  std::size_t nodes = std::size_t{1} << 20;  ///< Ids in all of them; the last is always kept.
};

/// One thread at a time.
class RequestAnswers {
 public:
  explicit RequestAnswers(AnswerLimits limits = {}) : limits_(limits) {}

  /// The answer to an earlier request of this id, or null. `content` is a digest of what is asked.
  /// Errors: kInvalidArgument where the id stood for something else.
  Result<const scenegraph::Applied*> find(const std::string& id, std::uint64_t content) const;
  /// An id that find() does not know.
  void retain(const std::string& id, std::uint64_t content, scenegraph::Applied answer);

 private:
  struct Kept {
    std::uint64_t content = 0;
    scenegraph::Applied answer;
  };

  const AnswerLimits limits_;
  std::unordered_map<std::string, Kept> answers_;
  std::deque<std::string> oldest_first_;
  std::size_t nodes_ = 0;
};

/// Errors: kInvalidArgument beyond kMaxRequestId.
Status check_request_id(std::string_view id);

}  // namespace sightline::server::scenes
