// One half of a scene and, once a ray has looked, its tree. The static one lives on from revision
// to revision.
#pragma once

#include <atomic>
#include <memory>

#include "scenegraph/instances/instance_list.h"

namespace sightline::scenegraph::instances {

/// Immutable, but for being opened and grown. Threads: all members, any; nobody waits for anybody.
class SceneHalf {
 public:
  SceneHalf(Half half, hierarchy::Hierarchy hierarchy)
      : half_(half), hierarchy_(std::move(hierarchy)) {}
  ~SceneHalf();
  SceneHalf(const SceneHalf&) = delete;
  SceneHalf& operator=(const SceneHalf&) = delete;

  /// Of the revision that this half was made for.
  const hierarchy::Hierarchy& hierarchy() const { return hierarchy_; }
  /// Made by whoever asks first.
  const Instances& instances() const;
  /// The same, or null if nobody has asked.
  const Instances* instances_so_far() const;

 private:
  const Half half_;
  const hierarchy::Hierarchy hierarchy_;
  mutable std::atomic<const Instances*> instances_{nullptr};
};

}  // namespace sightline::scenegraph::instances
