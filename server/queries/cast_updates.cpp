// Updates that come with rays or points.
#include "server/queries/cast_updates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "server/exec/rpc_status.h"

namespace sightline::server::queries {
namespace {

/// As many as the objects of a game move in a tick: they are applied sooner than another worker
/// wakes up.
constexpr int kFewUpdates = 1024;
constexpr std::size_t kFewBytes = std::size_t{64} << 10;

/// A negative number, as aliases are, where ids are asked for.
bool is_alias(std::uint64_t node) { return static_cast<std::int64_t>(node) < 0; }

Status check_node(std::uint64_t node) {
  if (!is_alias(node)) return {};
  return exec::invalid_argument(
      fmt::format("root or exclude names node {}: aliases of updates hold in the updates alone, "
                  "name nodes by their ids",
                  static_cast<std::int64_t>(node)),
      "ALIAS_IN_QUERY");
}

template <class Request>
Status check(const Request& request) {
  if (!request.apply().scene().empty() && request.apply().scene() != request.scene()) {
    return exec::invalid_argument(
        fmt::format("apply.scene is {}, and the scene is {}: they are the same, or apply.scene is "
                    "empty",
                    exec::quote(request.apply().scene()), exec::quote(request.scene())),
        "OTHER_SCENE");
  }
  if (request.consistency().requirement_case() != v1::Consistency::REQUIREMENT_NOT_SET) {
    return exec::invalid_argument(
        "a request with updates is answered at the revision that they make: leave out consistency",
        "CONSISTENCY_WITH_UPDATES");
  }
  if (request.has_shard()) {
    return exec::invalid_argument(
        "a request for one shard has updates: send them with one for all of the scene",
        "UPDATES_FOR_SHARD");
  }
  if (Status good = check_node(request.root()); !good) return good;
  for (const std::uint64_t node : request.exclude()) {
    if (Status good = check_node(node); !good) return good;
  }
  return {};
}

template <class Request>
Status check_none(const Request& request) {
  if (!request.has_apply()) return {};
  return exec::invalid_argument(
      "a stream is answered at one revision, and applies no updates: send them with a request of "
      "its own, or by ApplyUpdates",
      "UPDATES_IN_STREAM");
}

CastUpdates::Outcome pin(const Result<updates::AppliedAt>& applied) {
  if (!applied) return applied.error();
  auto snapshot = applied->snapshot();
  if (!snapshot) return snapshot.error();
  return CastUpdates::Pinned{applied->scene, *std::move(snapshot)};
}

}  // namespace

Status check_updates(const v1::CastRaysRequest& request) { return check(request); }
Status check_updates(const v1::QueryPointsRequest& request) { return check(request); }
Status check_no_updates(const v1::CastRaysRequest& request) { return check_none(request); }
Status check_no_updates(const v1::QueryPointsRequest& request) { return check_none(request); }

Status CastUpdates::admit() {
  const auto bytes = updates::bytes_held(updates_);
  return bytes ? job_.admit(*bytes) : Status(bytes.error());
}

bool CastUpdates::are_few() const {
  return updates_.updates_size() <= kFewUpdates && updates_.ByteSizeLong() <= kFewBytes;
}

void CastUpdates::enqueue(Done done) {
  job_.enqueue(
      [done = std::move(done)](const Result<updates::AppliedAt>& applied) { done(pin(applied)); });
}

std::optional<CastUpdates::Outcome> CastUpdates::run(Done done) {
  job_.run([this, done = std::move(done)](const Result<updates::AppliedAt>& applied) {
    outcome_.emplace(pin(applied));
    if (!one_is_done_.exchange(true)) return;  // run() returns it
    Outcome outcome = *std::move(outcome_);
    done(std::move(outcome));
  });
  if (!one_is_done_.exchange(true)) return std::nullopt;
  return std::move(outcome_);
}

}  // namespace sightline::server::queries
