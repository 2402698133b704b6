// Stands in for Embree's peers where Embree 3 was not found.
#include "tests/bench/embree/dynamic_peer.h"
#include "tests/bench/embree/peer.h"

namespace sightline::bench {

bool embree_found() { return false; }

Result<std::unique_ptr<EmbreePeer>> EmbreePeer::make(const SceneSource&, EmbreeSettings, int) {
  return Error{Code::kFailedPrecondition, "built without Embree 3 (Debian: libembree-dev)",
               "NO_EMBREE"};
}

Result<std::unique_ptr<EmbreePeer>> EmbreePeer::make_lazy(const SceneSource& scene, int threads) {
  return make(scene, {}, threads);
}

Result<std::unique_ptr<EmbreeDynamicPeer>> EmbreeDynamicPeer::make(const StagedScene&,
                                                                   const Motion&, EmbreeUpdate,
                                                                   int) {
  return Error{Code::kFailedPrecondition, "built without Embree 3 (Debian: libembree-dev)",
               "NO_EMBREE"};
}

}  // namespace sightline::bench
