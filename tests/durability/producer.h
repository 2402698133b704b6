// A producer that streams batches to a server that is killed, and resends what was not answered.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "tests/durability/findings.h"
#include "tests/server/support/api.h"
#include "tests/support/random.h"

namespace sightline::tests::durability {

inline const std::string kScene = "projects/p/scenes/killed";

/// Every batch sets a first and a last counter node to its sequence number, with other updates
/// between. Some batches are rejected as a whole.
class Producer {
 public:
  struct Options {
    std::vector<std::string> digests;  ///< Of meshes that batches put.
    bool relaxed = false;
    /// A revision: no batch is made while the last answer is much newer.
    const std::atomic<std::uint64_t>& seen;
  };
  Producer(int number, const Options& options, Findings& findings);

  /// Opens the stream and writes until the call breaks. Threads: one at a time.
  void run(Api& api);

  /// After run(): whether the batch is one that must be rejected.
  bool is_bad(std::uint64_t sequence) const { return bad_.contains(sequence); }
  std::uint64_t acknowledged() const { return acknowledged_; }
  std::uint64_t revision() const { return revision_; }    ///< The newest that an answer told.
  std::uint64_t committed() const { return committed_; }  ///< As the server said at the last open.
  /// Batches of a relaxed stream that were acknowledged and then lost with a server.
  std::uint64_t forgotten() const { return forgotten_; }
  const std::string& name() const { return name_; }

 private:
  struct Batch {
    std::uint64_t sequence = 0;
    std::vector<v1::Update> updates;
  };
  using Call = grpc::ClientReaderWriter<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>;

  bool open(Call& call);
  void begin_after(const v1::ProducerOpened& opened);
  void forget_after(std::uint64_t sequence);
  void write(Call& call);
  void receive(const v1::StreamUpdatesResponse& answer);
  void answered(std::uint64_t up_to);
  void learn(const v1::PutNodes& put);
  struct PutNode {
    std::uint64_t sequence = 0;  // of its batch
    std::uint64_t id = 0;
  };
  bool may_make() const;
  Batch make();
  void add_change(std::vector<v1::Update>& updates);

  const std::string name_;
  const Options options_;
  Findings& findings_;
  Random random_;
  std::mutex mutex_;  // protects all members below while run() is at work
  bool broken_ = false;
  std::deque<Batch> unanswered_;
  std::set<std::uint64_t> bad_;
  std::vector<PutNode> counters_, nodes_;
  std::uint64_t made_ = 0, acknowledged_ = 0, revision_ = 0, committed_ = 0;
  std::uint64_t sent_ = 0;     // in this call
  std::uint64_t learned_ = 0;  // the last batch whose nodes are known
  std::uint64_t forgotten_ = 0;
};

}  // namespace sightline::tests::durability
