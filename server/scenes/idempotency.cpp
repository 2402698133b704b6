// What a scene records of its writers, so that a request that is sent again is applied once.
#include "server/scenes/idempotency.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <utility>

#include "server/exec/rpc_status.h"

namespace sightline::server::scenes {

namespace {

/// What a record of an answer begins with. The ids of the nodes follow, then the request id.
struct AnswerHeader {
  std::uint64_t content = 0;
  std::uint64_t revision = 0;
  std::uint64_t nodes = 0;
};

AnswerHeader header_of(const Record& record) {
  AnswerHeader header;
  std::memcpy(&header, record.bytes().data(), sizeof(header));
  return header;
}

std::string_view id_of(const Record& record) {
  const std::size_t nodes = header_of(record).nodes * sizeof(scenegraph::model::NodeId);
  return record.bytes().substr(sizeof(AnswerHeader) + nodes);
}

std::string bytes_of(std::string_view id, const AnswerHeader& header,
                     const std::vector<scenegraph::model::NodeId>& nodes) {
  std::string bytes(reinterpret_cast<const char*>(&header), sizeof(header));
  if (!nodes.empty())
    bytes.append(reinterpret_cast<const char*>(nodes.data()), nodes.size() * sizeof(nodes[0]));
  return bytes.append(id);
}

scenegraph::Applied answer_of(const Record& record) {
  const AnswerHeader header = header_of(record);
  scenegraph::Applied answer{.revision = header.revision,
                             .nodes = std::vector<scenegraph::model::NodeId>(header.nodes)};
  if (header.nodes == 0) return answer;
  std::memcpy(answer.nodes.data(), record.bytes().data() + sizeof(header),
              header.nodes * sizeof(answer.nodes[0]));
  return answer;
}

}  // namespace

const RequestAnswers::Entry* RequestAnswers::find_entry(std::string_view id) const {
  const std::uint64_t digest = std::hash<std::string_view>{}(id);
  for (std::size_t i = entries_.size(); i-- > 0;) {
    const Entry& entry = entries_[i];
    if (entry.digest == digest && id_of(entry.record) == id) return &entry;
  }
  return nullptr;
}

Result<std::optional<scenegraph::Applied>> RequestAnswers::find(std::string_view id,
                                                                std::uint64_t content) const {
  const Entry* const entry = find_entry(id);
  if (entry == nullptr) return std::optional<scenegraph::Applied>();
  const AnswerHeader header = header_of(entry->record);
  if (header.content != content) return request_id_reused(std::string(id), header.revision);
  return std::optional(answer_of(entry->record));
}

Error request_id_reused(const std::string& id, std::uint64_t revision) {
  return {Code::kInvalidArgument,
          fmt::format("request id {} was used for another request, which made revision {}",
                      exec::quote(id), revision),
          "REQUEST_ID_REUSED"};
}

RequestAnswers::Entry RequestAnswers::prepare(std::string_view id, std::uint64_t content,
                                              const scenegraph::Applied& answer,
                                              std::size_t waiting) {
  const AnswerHeader header{content, answer.revision, answer.nodes.size()};
  Entry entry{.digest = std::hash<std::string_view>{}(id),
              .record = records_.keep(bytes_of(id, header, answer.nodes)),
              .nodes = answer.nodes.size()};
  entries_.reserve_more(waiting + 1);
  return entry;
}

void RequestAnswers::retain(Entry entry) noexcept {
  if (entry.record.bytes().empty()) return;
  const std::size_t nodes = entry.nodes;
  entries_.append(std::move(entry), nodes);
  entries_.trim();
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
  const auto known = producers_.find(name);
  if (known != producers_.end()) return &known->second;
  if (producers_.size() >= limit_) {
    return Error{Code::kResourceExhausted,
                 fmt::format("the scene has had {} producers, the limit is {}; "
                             "use their names again",
                             producers_.size(), limit_),
                 "TOO_MANY_PRODUCERS"};
  }
  // The map's key and the producer have the name.
  auto charge = memory_.reclaim_and_charge(exec::Held::kLogs, kBytesPerProducer + 2 * name.size());
  if (!charge) return charge.error();
  return &producers_.try_emplace(name, name, memory_, std::move(*charge)).first->second;
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
