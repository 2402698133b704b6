// A scene with what was said of it when it was created.
#include "server/stored_scene.h"

namespace sightline::server {

scenegraph::SceneSummary StoredScene::summary() {
  const auto snapshot = scene_.snapshot();
  {
    const std::lock_guard lock(summary_mutex_);
    if (summarized_revision_ == snapshot->revision()) return summary_;
  }
  const auto summary = scenegraph::summarize(*snapshot);
  const std::lock_guard lock(summary_mutex_);
  summarized_revision_ = summary.revision;
  summary_ = summary;
  return summary;
}

}  // namespace sightline::server
