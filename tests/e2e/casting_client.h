// A client that casts at a scene which others change, and checks the answers.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/server/support/live_server.h"
#include "tests/support/plain_history.h"
#include "tests/support/random_edits.h"
#include "tests/support/random_questions.h"

namespace sightline::tests {

inline const std::string kMovingScene = "projects/p/scenes/moving";

/// The shared state of the clients of a stress, and their progress.
struct ServedStress {
  explicit ServedStress(std::uint64_t updates) : wanted(updates) {}

  PlainHistory history;
  std::vector<MeshChoice> meshes;  ///< The uploaded meshes.
  const std::uint64_t wanted;
  std::atomic<std::uint64_t> applied{0}, refused{0}, outrun{0}, casts{0}, hits{0}, gone{0};

  bool done() const { return applied >= wanted || testing::Test::HasFailure(); }
};

/// Creates the scene, uploads meshes, and puts the ground. Fails the test on an error.
void begin(Api& api, ServedStress& stress);

/// Has its own connection. Threads: one caller.
class CastingClient {
 public:
  CastingClient(ServedStress& stress, int port, std::uint64_t seed)
      : stress_(stress), api_(connect(port)), random_(seed) {}

  /// Casts random rays at the latest revision, at one that is at least as new as it knows, or at an
  /// exact one; fails the test if the answer differs from brute force at the revision that it
  /// names. Without `judged`, the answer is not compared.
  void cast(bool judged = true);

  /// Reports a revision that this client has made.
  void record_revision(const v1::SceneRevision& revision);

 protected:
  ServedStress& stress_;
  Api api_;
  Random random_;

 private:
  v1::CastRaysRequest request(const RandomQuestion& question);
  void judge(const PlainScene& plain, const RandomQuestion& question, v1::QueryKind kind,
             const v1::CastRaysResponse& reply);

  v1::SceneRevision known_;  // The newest revision that this client knows
};

/// The status that an error of this code has on the wire.
grpc::StatusCode wire_code(Code code);

}  // namespace sightline::tests
