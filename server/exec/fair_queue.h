// Divides worker time among clients and scenes: deficit round robin.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <string>

namespace sightline::server::exec {

/// The owner of work. Time is divided level by level: among principals, among the connections of
/// one, among the scenes of a connection. A machine has one share, however many connections it
/// opens, and clients behind one address divide its share.
struct FlowKey {
  std::string principal, connection, scene;
};

/// One slice of a job. Returns whether the job has more. It must not throw.
using Slice = std::function<bool()>;

/// Waiting jobs in flows, and whose turn it is. The jobs of one flow run in order of arrival.
///
/// Deficit round robin (Shreedhar and Varghese 1995): a turn gives a flow kQuantum. The cost of a
/// slice is known only after it, so it is paid then. An idle flow keeps no credit, but its debt: a
/// client that waits for each answer and one that does not get the same.
///
/// The unit of cost is time on a worker, because workers are what is divided: it covers decoding,
/// growing, searching and encoding alike. Time of helping threads is free, as only threads help
/// that no job waits for.
///
/// Threads: one at a time.
class FairQueue {
 public:
  using Cost = std::chrono::nanoseconds;
  static constexpr Cost kQuantum = std::chrono::milliseconds(5);
  /// No flow owes more.
  static constexpr Cost kMostDebt = std::chrono::milliseconds(500);

  /// The jobs of a connection or a scene are held while it has `long_turns` long turns: more
  /// workers would not help it, and others need them.
  explicit FairQueue(std::size_t long_turns);
  ~FairQueue();

  class Flow;
  struct Turn {
    Flow* flow = nullptr;    ///< Valid until end().
    std::list<Slice> job{};  ///< Exactly one job.
    bool run() { return job.front()(); }
  };

  /// Appends a job to its flow. Throws std::bad_alloc, as mark_long() does, and no other member.
  void push(const FlowKey& key, Slice slice);
  /// Whether a job waits that is not held.
  bool ready() const;
  /// The next job of the flow whose turn it is. Call it only if ready().
  Turn take();
  /// Charges the flow of a turn.
  void charge(Flow& flow, Cost cost);
  /// Notes that a turn is long. Call it once for a turn.
  void mark_long(Flow& flow);
  /// Ends a turn, with `was_long` if it was marked. `again`: its job has more and is the next of
  /// its flow.
  void end(Turn turn, bool was_long, bool again);

  /// Flows that wait, run or owe, and the levels above them.
  std::size_t flows() const;

 private:
  void hold_scene(const std::string& scene, bool held);

  const std::size_t long_turns_;
  std::map<std::string, std::size_t> long_scenes_;  // the long turns of each
  std::unique_ptr<Flow> root_;
};

}  // namespace sightline::server::exec
