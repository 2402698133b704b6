// The producers that stream updates into a scene.
#include "server/scenes/producers.h"

#include <fmt/format.h>

#include <algorithm>

#include "server/exec/rpc_status.h"

namespace sightline::server::scenes {

void Producer::commit(std::uint64_t sequence, const std::vector<scenegraph::model::NodeId>& nodes) {
  put.append({sequence, nodes}, nodes.size());
  put.trim();
  last_committed = sequence;
}

Result<Producer*> Producers::open(const std::string& name) {
  if (!producers_.contains(name) && producers_.size() >= limit_) {
    return Error{Code::kResourceExhausted,
                 fmt::format("the scene has had {} producers, the limit is {}; "
                             "use their names again",
                             producers_.size(), limit_),
                 "TOO_MANY_PRODUCERS"};
  }
  return &producers_[name];
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
