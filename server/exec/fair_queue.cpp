// Divides worker time among clients and scenes: deficit round robin.
#include "server/exec/fair_queue.h"

#include <algorithm>
#include <deque>
#include <list>
#include <utility>

namespace sightline::server::exec {

/// The root, a principal, a connection or, at the bottom, the flow of a scene.
class FairQueue::Flow {
 public:
  Flow(Flow* parent, std::string name) : above(parent), key(std::move(name)), unlisted{this} {}

  Flow& below(const std::string& child) {
    std::unique_ptr<Flow>& flow = children[child];
    if (flow == nullptr) flow = std::make_unique<Flow>(this, child);
    return *flow;
  }

  std::size_t offered() const { return held ? 0 : ready; }

  void add_ready(std::size_t change) {  // may be negative, modulo
    for (Flow* at = this; at != nullptr; at = at->held ? nullptr : at->above) at->ready += change;
  }

  void set_held(bool now) {
    if (held == now) return;
    held = now;
    above->add_ready(now ? -ready : ready);
  }

  /// Gives the flow a place in the order of turns, which it has while jobs wait or it owes.
  void enlist() {
    for (Flow* at = this; at->above != nullptr; at = at->above) {
      at->above->turns.splice(at->above->turns.end(), at->unlisted);
    }
  }

  Flow& next() {
    for (;;) {
      Flow& first = *turns.front();
      if (first.offered() > 0) {
        if (!std::exchange(first.has_quantum, true)) first.deficit += kQuantum;
        if (first.deficit > Cost::zero()) return first;
      } else if (first.waiting == 0) {
        first.deficit += kQuantum;
      }
      first.has_quantum = false;
      if (first.waiting > 0 || first.deficit < Cost::zero()) {
        turns.splice(turns.end(), turns, turns.begin());
        continue;
      }
      first.unlisted.splice(first.unlisted.end(), turns, turns.begin());
      first.deficit = Cost::zero();
      first.remove_if_idle();
    }
  }

  /// Removes an idle flow with all below it, whose debts among themselves are forgotten.
  void remove_if_idle() {
    if (above == nullptr || unlisted.empty() || running > 0) return;
    Flow* parent = above;
    parent->children.erase(parent->children.find(key));
    parent->remove_if_idle();
  }

  Flow* const above;
  const std::string key;
  std::map<std::string, std::unique_ptr<Flow>> children;
  // Elements move between lists, so that a worker needs no memory to take a job and to return it.
  std::list<Flow*> turns;     // the children's
  std::list<Flow*> unlisted;  // this flow, unless it is in above->turns
  std::list<Slice> jobs;
  std::size_t waiting = 0, ready = 0;  // jobs here and below: all, and those not held below
  std::size_t running = 0;             // turns
  std::size_t long_turns = 0;
  Cost deficit{0};
  bool has_quantum = false;  // its turn has given it one
  bool held = false;
};

FairQueue::FairQueue(std::size_t long_turns)
    : long_turns_(long_turns), root_(std::make_unique<Flow>(nullptr, "")) {}

FairQueue::~FairQueue() = default;

bool FairQueue::ready() const { return root_->ready > 0; }

void FairQueue::push(const FlowKey& key, Slice slice) {
  Flow& flow = root_->below(key.principal).below(key.connection).below(key.scene);
  if (const auto found = long_scenes_.find(key.scene); found != long_scenes_.end())
    flow.set_held(found->second >= long_turns_);
  flow.jobs.push_back(std::move(slice));
  for (Flow* at = &flow; at != nullptr; at = at->above) ++at->waiting;
  flow.add_ready(1);
  flow.enlist();
}

FairQueue::Turn FairQueue::take() {
  Flow* flow = root_.get();
  while (flow->jobs.empty()) flow = &flow->next();
  Turn turn{flow};
  turn.job.splice(turn.job.end(), flow->jobs, flow->jobs.begin());
  for (Flow* at = flow; at != nullptr; at = at->above) {
    --at->waiting;
    ++at->running;
  }
  flow->add_ready(std::size_t{0} - 1);
  return turn;
}

void FairQueue::charge(Flow& flow, Cost cost) {
  for (Flow* at = &flow; at->above != nullptr; at = at->above)
    at->deficit = std::max(at->deficit - cost, -kMostDebt);
  flow.enlist();
}

void FairQueue::mark_long(Flow& flow) {
  std::size_t& of_scene = long_scenes_[flow.key];  // may throw
  if (++of_scene >= long_turns_) hold_scene(flow.key, true);
  if (++flow.above->long_turns >= long_turns_) flow.above->set_held(true);
}

void FairQueue::end(Turn turn, bool was_long, bool again) {
  Flow& flow = *turn.flow;
  if (was_long) {
    if (--flow.above->long_turns < long_turns_) flow.above->set_held(false);
    const auto scene = long_scenes_.find(flow.key);
    if (--scene->second < long_turns_) hold_scene(flow.key, false);
    if (scene->second == 0) long_scenes_.erase(scene);
  }
  for (Flow* at = &flow; at != nullptr; at = at->above) {
    --at->running;
    at->waiting += again ? 1 : 0;
  }
  if (again) {
    flow.jobs.splice(flow.jobs.begin(), turn.job);
    flow.add_ready(1);
    flow.enlist();
  }
  flow.remove_if_idle();
}

void FairQueue::hold_scene(const std::string& scene, bool held) {
  for (const auto& [principal, of_principal] : root_->children) {
    for (const auto& [connection, of_connection] : of_principal->children) {
      const auto flow = of_connection->children.find(scene);
      if (flow != of_connection->children.end()) flow->second->set_held(held);
    }
  }
}

std::size_t FairQueue::flows() const {
  std::size_t flows = 0;
  std::deque<const Flow*> open{root_.get()};
  for (; !open.empty(); open.pop_front()) {
    for (const auto& [key, child] : open.front()->children) open.push_back(child.get());
    flows += open.front()->children.size();
  }
  return flows;
}

}  // namespace sightline::server::exec
