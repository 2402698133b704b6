// The revisions that streams of rays keep between two requests.
#include "server/scenes/revision_pins.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <set>
#include <utility>

#include "scenegraph/instances/scene_trees.h"
#include "server/scenes/applied_updates.h"

namespace sightline::server::scenes {
namespace {

using scenegraph::instances::Level;
using scenegraph::instances::SceneTree;

constexpr std::uint64_t kConnectionShareOfPins = 1;  // a principal's share is that of each

/// Whether the scene has this object of the revision, too.
bool is_kept(const StoredScene& scene, const scenegraph::revision::Snapshot& revision) {
  const auto kept = scene.at(revision.revision());
  return kept && kept->get() == &revision;
}

/// The bytes that the pin pays for. A revision whose scene is gone is held by its readers alone.
std::uint64_t paid_for(const RevisionPins::Pin& pin) {
  const auto revision = pin.revision.lock();
  if (revision == nullptr) return 0;
  const auto scene = pin.scene.lock();
  if (scene == nullptr)
    return bytes_of_replaced(revision->node_count()) + scenes::bytes_of(revision->shared_trees());
  if (is_kept(*scene, *revision)) return 0;
  return scene->past().bytes(revision->revision()) +
         bytes_of_replaced_trees(*revision, *scene->snapshot());
}

}  // namespace

RevisionPins::RevisionPins(std::uint64_t budget)
    : budget_(budget),
      limits_(exec::ShareLimits::of(budget / kPinsShare, kConnectionShareOfPins)) {}

void RevisionPins::enter(const void* call, Pin pin) {
  const std::lock_guard lock(mutex_);
  pins_.insert_or_assign(call, std::move(pin));
}

void RevisionPins::leave(const void* call) {
  const std::lock_guard lock(mutex_);
  pins_.erase(call);
}

/// The caller holds the mutex.
RevisionPins::Bill RevisionPins::bill() const {
  Bill bill;
  std::set<std::pair<std::string, const void*>> paid;
  for (const auto& [call, pin] : pins_) {
    const std::uint64_t bytes = paid_for(pin);
    if (bytes == 0) continue;
    bill.pins.push_back({call, &pin, pin.rest->since()});
    bill.by_connection[pin.caller.connection] += bytes;
    if (!paid.emplace(pin.caller.principal, pin.revision.lock().get()).second) continue;
    bill.by_principal[pin.caller.principal] += bytes;
    bill.all += bytes;
  }
  return bill;
}

/// The caller holds the mutex. It releases `let_go` without it, as that may take long.
bool RevisionPins::end_oldest(const Bill& bill, const std::function<bool(const Paid&)>& may_go,
                              const std::string& why, SnapshotPointer& let_go) {
  std::vector<Paid> resting;
  for (const Paid& paid : bill.pins) {
    if (paid.since != exec::PeerWait::kNever && may_go(paid)) resting.push_back(paid);
  }
  std::ranges::sort(resting, [&](const Paid& a, const Paid& b) {
    const std::uint64_t of_a = bill.by_connection.at(a.pin->caller.connection);
    const std::uint64_t of_b = bill.by_connection.at(b.pin->caller.connection);
    return of_a != of_b ? of_a > of_b : a.since < b.since;
  });
  for (const Paid& paid : resting) {
    const auto revision = paid.pin->revision.lock();
    const Error error{
        Code::kResourceExhausted,
        fmt::format("{}; the revision {} that this stream had kept was let go: open the stream "
                    "again, it is then answered at the newest revision",
                    why, revision == nullptr ? 0 : revision->revision()),
        "REVISION_LET_GO"};
    let_go = paid.pin->let_go(error);
    if (let_go == nullptr) continue;
    pins_.erase(paid.call);
    ++ended_;
    return true;
  }
  return false;
}

void RevisionPins::end_over_shares() {
  for (;;) {
    SnapshotPointer let_go;  // released after the lock is
    const std::lock_guard lock(mutex_);
    const Bill now = bill();
    const auto is_over = [&](const Paid& paid) {
      return now.by_principal.at(paid.pin->caller.principal) > limits_.principal;
    };
    const bool any = now.all > limits_.all;
    const std::string why = fmt::format(
        "streams of rays that rest keep old revisions of {} bytes, the limit is {} (of one address "
        "{})",
        now.all, limits_.all, limits_.principal);
    if (!end_oldest(now, is_over, why, let_go) &&
        !(any && end_oldest(
                     now, [](const Paid&) { return true; }, why, let_go)))
      return;
  }
}

bool RevisionPins::end_one() {
  SnapshotPointer let_go;
  const std::lock_guard lock(mutex_);
  const Bill now = bill();
  const std::string why = fmt::format(
      "the memory budget of {} bytes is used up, and streams of rays that rest keep old "
      "revisions of {}",
      budget_, now.all);
  // Principals all of whose pins are in work are skipped.
  auto principals = now.by_principal;
  while (!principals.empty()) {
    const auto most = std::ranges::max_element(
        principals, {}, [](const auto& principal) { return principal.second; });
    if (end_oldest(
            now, [&](const Paid& paid) { return paid.pin->caller.principal == most->first; }, why,
            let_go))
      return true;
    principals.erase(most);
  }
  return false;
}

std::uint64_t RevisionPins::bytes() const {
  const std::lock_guard lock(mutex_);
  return bill().all;
}

std::uint64_t RevisionPins::tree_bytes() const {
  std::set<const SceneTree*> counted;
  std::uint64_t bytes = 0;
  const std::lock_guard lock(mutex_);
  for (const auto& [call, pin] : pins_) {
    const auto revision = pin.revision.lock();
    if (revision == nullptr) continue;
    const auto scene = pin.scene.lock();
    if (scene != nullptr) {
      if (is_kept(*scene, *revision)) continue;
      for (const Level& level : scene->snapshot()->shared_trees().levels)
        counted.insert(level.tree.get());
    }
    for (const Level& level : revision->shared_trees().levels) {
      if (counted.insert(level.tree.get()).second) bytes += bytes_of(*level.tree);
    }
  }
  return bytes;
}

std::uint64_t RevisionPins::ended() const {
  const std::lock_guard lock(mutex_);
  return ended_;
}

}  // namespace sightline::server::scenes
