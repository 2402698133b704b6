// Follows a scene through a watch, and holds it against a plain scene and brute force.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "server/blobs/blob_store.h"
#include "server/exec/memory_account.h"
#include "tests/durability/findings.h"
#include "tests/durability/producer.h"
#include "tests/server/support/api.h"
#include "tests/support/plain_scene.h"
#include "tests/support/scenes.h"

namespace sightline::tests::durability {

class Witness {
 public:
  explicit Witness(Findings& findings) : findings_(findings) {}

  /// A mesh that producers put; its digest.
  std::string add_mesh(const TestMesh& mesh);

  /// Goes back to this revision, after which the server has lost revisions that a relaxed stream
  /// made.
  void go_back(std::uint64_t revision);
  /// Follows the scene until the call breaks; with `until`, until that revision.
  void watch(Api& api, std::uint64_t until = 0);

  /// Casts rays at the newest revision and at an older one, while no client writes.
  void check_rays(Api& api, std::size_t count, std::uint64_t seed);

  std::uint64_t revision() const { return revisions_.back().revision; }
  /// The same. Threads: any.
  const std::atomic<std::uint64_t>& seen() const { return seen_; }
  std::uint64_t rays() const { return rays_; }
  const std::set<std::string>& requests() const { return requests_; }
  /// Batches that were left out: the caller knows which had to be.
  const std::map<std::string, std::set<std::uint64_t>>& skipped() const { return skipped_; }

 private:
  struct Counter {
    std::string producer;
    bool first = false;
  };
  struct Kept {
    std::uint64_t revision = 0;
    PlainScene scene;
    std::map<std::int64_t, Counter> counters;      // by node
    std::map<std::string, std::uint64_t> applied;  // the last batch of each producer
  };

  void take(std::uint64_t revision, const std::vector<v1::Update>& updates);
  void name_nodes(const v1::PutNode& put);
  void check_batch(std::uint64_t revision, const std::vector<v1::Update>& updates);
  void note_batch(const std::string& producer, std::uint64_t sequence);
  void cast(Api& api, const Kept& at, bool exact, std::size_t count, std::uint64_t seed);

  Findings& findings_;
  server::exec::MemoryAccount memory_{std::uint64_t{1} << 30};
  server::blobs::BlobStore meshes_{memory_};
  std::deque<Kept> revisions_ = std::deque<Kept>(1);  // the last ones
  std::atomic<std::uint64_t> seen_{0};
  std::map<std::string, std::set<std::uint64_t>> skipped_;
  std::set<std::string> requests_;
  std::uint64_t rays_ = 0;
};

}  // namespace sightline::tests::durability
