// What a scene records of its writers, so that a request that is sent again is applied once.
#include "server/scenes/idempotency.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "server/exec/rpc_status.h"

namespace sightline::server::scenes {

Result<const scenegraph::Applied*> RequestAnswers::find(const std::string& id,
                                                        std::uint64_t content) const {
  const auto found = answers_.find(id);
  if (found == answers_.end()) return nullptr;
  if (found->second.content == content) return &found->second.answer;
  return request_id_reused(id, found->second.answer.revision);
}

Error request_id_reused(const std::string& id, std::uint64_t revision) {
  return {Code::kInvalidArgument,
          fmt::format("request id {} was used for another request, which made revision {}",
                      exec::quote(id), revision),
          "REQUEST_ID_REUSED"};
}

RequestAnswers::Entry RequestAnswers::prepare(const std::string& id, std::uint64_t content,
                                              const scenegraph::Applied& answer,
                                              std::size_t waiting) {
  Answers one;
  const std::uint64_t bytes =
      sizeof(Kept) + id.size() + answer.nodes.size() * sizeof(scenegraph::model::NodeId);
  one.emplace(id, Kept{content, answer, memory_.record(exec::Held::kLogs, bytes)});
  Entry entry{id, one.extract(one.begin())};
  answers_.reserve(answers_.size() + waiting + 1);
  ids_.reserve_more(waiting + 1);
  return entry;
}

void RequestAnswers::retain(Entry entry) noexcept {
  if (entry.answer.empty()) return;
  ids_.append(std::move(entry.id), entry.answer.mapped().answer.nodes.size());
  answers_.insert(std::move(entry.answer));
  for (const std::string& dropped : ids_.trim()) answers_.erase(dropped);
}

Status check_request_id(std::string_view id) {
  if (id.size() <= kMaxRequestId) return {};
  return Error{Code::kInvalidArgument,
               fmt::format("a request id has {} bytes, the limit is {}", id.size(), kMaxRequestId),
               "REQUEST_ID_TOO_LONG"};
}

void Producer::commit(Put batch) {
  last_committed = batch.sequence;
  const std::size_t nodes = batch.nodes.size();
  put.append(std::move(batch), nodes);
  put.trim();
}

Result<Producer*> Producers::open(const std::string& name) {
  if (!producers_.contains(name) && producers_.size() >= limit_) {
    return Error{Code::kResourceExhausted,
                 fmt::format("the scene has had {} producers, the limit is {}; "
                             "use their names again",
                             producers_.size(), limit_),
                 "TOO_MANY_PRODUCERS"};
  }
  Producer& producer = producers_[name];
  producer.name = name;
  return &producer;
}

Status check_producer_name(std::string_view name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  };
  if (!name.empty() && name.size() <= kMaxProducerName && std::ranges::all_of(name, allowed))
    return {};
  return Error{Code::kInvalidArgument,
               fmt::format("producer {} does not match [A-Za-z0-9._-]{{1,{}}}", exec::quote(name),
                           kMaxProducerName),
               "BAD_PRODUCER"};
}

}  // namespace sightline::server::scenes
