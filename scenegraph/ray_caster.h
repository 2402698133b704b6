// One ray through the scene: instances near to far, each in its own frame.
#pragma once

#include "accel/lazy/mesh_tree.h"
#include "scenegraph/instances.h"
#include "scenegraph/trace.h"

namespace sightline::scenegraph {

/// For one block of rays, on one thread that is pinned to an epoch.
class RayCaster {
 public:
  RayCaster(const Instances& instances, const TraceOptions& options);

  accel::Hit cast(const accel::Ray& ray);
  TraceStats stats() const;

 private:
  struct Visit;

  void enter_instance(const accel::Ray& ray, std::uint32_t index, accel::MeshQuery& query);
  accel::Hit surface(const accel::Ray& ray, const accel::MeshQuery& query) const;

  const Instances& instances_;
  TraceOptions options_;
  accel::AtUnbuilt at_unbuilt_;
  std::uint32_t nearest_ = 0;  // instance of the best hit so far
  TraceStats stats_;
  accel::WalkCounters walked_;
  accel::BuildCounters built_;
};

}  // namespace sightline::scenegraph
