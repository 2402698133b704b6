// A scene with what was said of it when it was created.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "scenegraph/scene.h"
#include "scenegraph/snapshot.h"

namespace sightline::server {

enum class UpAxis : std::uint8_t { kUnspecified, kY, kZ };

/// Recorded as given; nothing is converted by it.
struct SceneInfo {
  std::string name;  ///< Resource name.
  UpAxis up_axis = UpAxis::kUnspecified;
  double meters_per_unit = 0;  ///< 0: unknown.
};

class StoredScene {
 public:
  explicit StoredScene(SceneInfo info) : info_(std::move(info)) {}

  const SceneInfo& info() const { return info_; }
  scenegraph::Scene& scene() { return scene_; }

  /// Of the current revision. Walks the scene once per revision. Threads: any.
  scenegraph::SceneSummary summary();

 private:
  const SceneInfo info_;
  scenegraph::Scene scene_;
  std::mutex summary_mutex_;
  std::optional<std::uint64_t> summarized_revision_;
  scenegraph::SceneSummary summary_;
};

}  // namespace sightline::server
