// A client that casts at a scene which others change, and judges what it is answered.
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

/// What the clients of a stress have in common, and how far they have come.
struct ServedStress {
  explicit ServedStress(std::uint64_t updates) : wanted(updates) {}

  PlainHistory history;
  std::vector<MeshChoice> meshes;  ///< Uploaded.
  const std::uint64_t wanted;
  std::atomic<std::uint64_t> applied{0}, refused{0}, outrun{0}, casts{0}, hits{0}, gone{0};

  bool done() const { return applied >= wanted || testing::Test::HasFailure(); }
};

/// Makes the scene, uploads meshes, and puts the ground. Fails the test if it cannot.
void begin(Api& api, ServedStress& stress);

/// Has a connection of its own. One thread.
class CastingClient {
 public:
  CastingClient(ServedStress& stress, int port, std::uint64_t seed)
      : stress_(stress), api_(connect(port)), random_(seed) {}

  /// Asks something at random, of the latest revision, one that is at least as new as it knows, or
  /// an exact one; fails the test where the answer is not that of brute force at the revision that
  /// it names.
  void cast();

  /// To be told of a revision that this client has made.
  void knows(const v1::SceneRevision& revision);

 protected:
  ServedStress& stress_;
  Api api_;
  Random random_;

 private:
  v1::CastRaysRequest request(const RandomQuestion& question);
  void judge(const PlainScene& plain, const RandomQuestion& question, v1::QueryKind kind,
             const v1::CastRaysResponse& reply);

  v1::SceneRevision known_;  // the newest that this client knows of
};

/// The status that an error of this code has on the wire.
grpc::StatusCode wire_code(Code code);

}  // namespace sightline::tests
