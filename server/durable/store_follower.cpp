// Follows what other servers do to the scenes of a shared store.
#include "server/durable/store_follower.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <string>
#include <utility>

#include "server/exec/rpc_status.h"

namespace sightline::server::durable {
namespace {

std::int64_t milliseconds(scenes::Replica::Clock::duration time) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
}

}  // namespace

StoreFollower::StoreFollower(const StoreParts& parts, StoreCatalog& catalog,
                             scenes::SceneStore& scenes)
    : parts_(parts), catalog_(catalog), scenes_(scenes), replica_(*catalog.replica()) {
  parts_.store.watch([this](std::span<const store::SceneId> ids) { changed(ids); });
}

StoreFollower::~StoreFollower() {
  replica_.stop();
  parts_.store.unwatch();
}

/// Runs on the thread of the store.
void StoreFollower::changed(std::span<const store::SceneId> ids) {
  const Status noted = exec::to_status([&]() -> Status {
    bool all_known = !ids.empty();
    for (const store::SceneId id : ids) {
      const auto known = known_.find(id);
      const auto scene = known == known_.end() ? nullptr : known->second.lock();
      if (scene != nullptr) scene->follower()->follow_soon(parts_.compute);
      all_known = all_known && scene != nullptr;
    }
    return all_known ? Status() : compare();
  });
  if (!noted) spdlog::debug("event=store_not_compared error={}", noted.error().message);
}

/// Compares all scenes with those of the store. The known ones are listed first: a scene that is
/// made here meanwhile is not taken for a removed one.
Status StoreFollower::compare() {
  const Clock::time_point asked = Clock::now();
  auto known = scenes_.by_number();
  const auto heads = parts_.store.heads();
  if (!heads) return heads.error();
  for (const store::SceneHead& head : *heads) {
    const auto scene = known.extract(head.id);
    if (!scene.empty()) {
      scene.mapped()->follower()->note(head.revision, parts_.compute);
      continue;
    }
    auto found = catalog_.find(head.id);
    if (found) {
      scenes_.adopt(std::move(*found));
    } else if (found.error().code != Code::kNotFound && found.error().code != Code::kDataLoss) {
      return found.error();
    }
  }
  for (const auto& [id, scene] : known) scenes_.forget(scene);
  known_.clear();
  for (const auto& [id, scene] : scenes_.by_number()) known_.emplace(id, scene);
  replica_.heard(asked);
  return {};
}

StoreFollower::Behind StoreFollower::behind() const {
  Behind most;
  for (const auto& [id, scene] : scenes_.by_number()) {
    const scenes::Lag lag = scene->follower()->lag();
    most.lag.revisions = std::max(most.lag.revisions, lag.revisions);
    if (lag.time <= most.lag.time) continue;
    most.lag.time = lag.time;
    most.scene = scene->info().name;
  }
  return most;
}

Status StoreFollower::serves() const {
  if (Status fresh = replica_.fresh(); !fresh) return fresh;
  const Behind most = behind();
  if (most.lag.time <= kMaxLag) return {};
  return Error{Code::kUnavailable,
               fmt::format("{} is behind for {} ms; up to {} ms are allowed", most.scene,
                           milliseconds(most.lag.time), kMaxLag.count()),
               "BEHIND"};
}

Status StoreFollower::ready() const {
  if (Status good = serves(); !good) return good;
  const auto staleness = replica_.staleness();
  if (staleness <= kMaxLag) return {};
  return Error{Code::kUnavailable,
               fmt::format("the store was not reached for {} ms", milliseconds(staleness)),
               "STORE_AWAY"};
}

}  // namespace sightline::server::durable
