// Revisions that a scene does not keep any more and that readers still have.
#include "server/scenes/past_revisions.h"

#include <algorithm>
#include <memory>
#include <new>
#include <ranges>
#include <utility>

#include "server/scenes/applied_updates.h"

namespace sightline::server::scenes {
namespace {

/// Charges are compared with what is held when they have doubled and grown by this: that costs a
/// small part of what the updates cost.
constexpr std::uint64_t kGrowth = std::uint64_t{64} << 10;

}  // namespace

PastRevisions::~PastRevisions() {
  Charge charge = memory_.record(exec::Held::kRevisions, 0);
  std::vector<std::weak_ptr<const void>> users;
  for (Past& past : past_) {
    if (!past.nodes.expired()) users.push_back(past.nodes.life());
    charge.add(std::move(past.charge));
  }
  if (!users.empty()) memory_.keep_while(std::move(users), std::move(charge));
}

void PastRevisions::add(const scenegraph::revision::Snapshot& revision, Charge charge) noexcept {
  const std::uint64_t bytes = charge.bytes();
  const std::lock_guard lock(mutex_);
  try {
    past_.push_back({revision.revision(), Nodes::Weak(revision.nodes()), std::move(charge), bytes});
  } catch (const std::bad_alloc&) {  // not counted
  }
}

void PastRevisions::release_gone(const scenegraph::revision::Snapshot& next) {
  const std::lock_guard lock(mutex_);
  std::size_t kept = 0;
  for (Past& past : past_) {
    if (!past.nodes.expired()) {
      if (&past != &past_[kept]) past_[kept] = std::move(past);
      ++kept;
    } else if (kept > 0) {
      past_[kept - 1].charge.add(std::move(past.charge));
    }
  }
  past_.erase(past_.begin() + static_cast<std::ptrdiff_t>(kept), past_.end());
  Nodes after = next.nodes();
  for (Past& past : std::views::reverse(past_)) {
    Nodes nodes = past.nodes.lock();
    if (nodes.size() == 0) continue;  // its last reader has gone just now; a later call sees it
    if (past.charge.bytes() > 2 * past.counted + kGrowth) {
      const std::uint64_t held = bytes_of_replaced(nodes.count_not_in(after));
      past.charge.resize(std::min(past.charge.bytes(), held));
      past.counted = past.charge.bytes();
    }
    after = std::move(nodes);
  }
}

std::uint64_t PastRevisions::bytes(std::uint64_t revision) const {
  const std::lock_guard lock(mutex_);
  std::uint64_t bytes = 0;
  for (const Past& past : past_) bytes += past.revision == revision ? past.charge.bytes() : 0;
  return bytes;
}

std::uint64_t PastRevisions::bytes() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t bytes = 0;
  for (const Past& past : past_) bytes += past.charge.bytes();
  return bytes;
}

}  // namespace sightline::server::scenes
