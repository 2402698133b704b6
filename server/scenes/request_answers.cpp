// The last answers to requests with a request id.
#include "server/scenes/request_answers.h"

#include <fmt/format.h>

#include <utility>

#include "server/exec/rpc_status.h"

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
  ids_.append(id, answer.nodes.size());
  answers_.emplace(id, Kept{content, std::move(answer)});
  for (const std::string& dropped : ids_.trim()) answers_.erase(dropped);
}

Status check_request_id(std::string_view id) {
  if (id.size() <= kMaxRequestId) return {};
  return Error{Code::kInvalidArgument,
               fmt::format("a request id has {} bytes, the limit is {}", id.size(), kMaxRequestId),
               "REQUEST_ID_TOO_LONG"};
}

}  // namespace sightline::server::scenes
