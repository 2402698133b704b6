// The last answers to requests that were given an id.
#include "server/scenes/request_answers.h"

#include <fmt/format.h>

#include <utility>

#include "server/exec/quote.h"

namespace sightline::server::scenes {

Result<const scenegraph::Applied*> RequestAnswers::find(const std::string& id,
                                                        std::uint64_t content) const {
  const auto found = answers_.find(id);
  if (found == answers_.end()) return nullptr;
  if (found->second.content == content) return &found->second.answer;
  return Error{Code::kInvalidArgument,
               fmt::format("request id {} was used for another request, which made revision {}",
                           exec::quote(id), found->second.answer.revision),
               "REQUEST_ID_REUSED"};
}

void RequestAnswers::retain(const std::string& id, std::uint64_t content,
                            scenegraph::Applied answer) {
  nodes_ += answer.nodes.size();
  answers_.emplace(id, Kept{content, std::move(answer)});
  oldest_first_.push_back(id);
  while (oldest_first_.size() > limits_.answers ||
         (oldest_first_.size() > 1 && nodes_ > limits_.nodes)) {
    const auto oldest = answers_.find(oldest_first_.front());
    nodes_ -= oldest->second.answer.nodes.size();
    answers_.erase(oldest);
    oldest_first_.pop_front();
  }
}

Status check_request_id(std::string_view id) {
  if (id.size() <= kMaxRequestId) return {};
  return Error{Code::kInvalidArgument,
               fmt::format("a request id has {} bytes, the limit is {}", id.size(), kMaxRequestId),
               "REQUEST_ID_TOO_LONG"};
}

}  // namespace sightline::server::scenes
