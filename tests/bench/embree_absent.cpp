// Stands in for embree_peer.cpp where Embree 3 was not found.
#include "tests/bench/embree_peer.h"

namespace sightline::bench {

bool embree_found() { return false; }

Result<std::unique_ptr<EmbreePeer>> EmbreePeer::make(const SceneSource&, EmbreeSettings, int) {
  return Error{Code::kFailedPrecondition, "built without Embree 3 (Debian: libembree-dev)",
               "NO_EMBREE"};
}

Result<std::unique_ptr<EmbreePeer>> EmbreePeer::make_lazy(const SceneSource& scene, int threads) {
  return make(scene, {}, threads);
}

}  // namespace sightline::bench
