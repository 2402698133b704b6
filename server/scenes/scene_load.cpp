// Reads a scene from its journal.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "server/exec/rpc_status.h"
#include "server/scenes/applied_updates.h"
#include "server/scenes/stored_scene.h"

namespace sightline::server::scenes {

/// Applies the batches to the base as they were applied first.
class StoredScene::Loader final : public JournalReader {
 public:
  /// `again`: the scene is loaded, and what it has is replaced.
  explicit Loader(StoredScene& scene, bool again = false) : scene_(scene), again_(again) {}

  Status base(scenegraph::SceneContent content) override {
    std::uint64_t names = 0;
    for (const scenegraph::model::Node& node : content.nodes) names += bytes_of_texts(node);
    const std::size_t nodes = content.nodes.size();
    const std::uint64_t revision = content.revision;
    auto charge =
        scene_.memory_.reclaim_and_charge(exec::Held::kNodes, bytes_of_scene(nodes, names));
    if (!charge) return charge.error();
    const auto before = scene_.snapshot();
    if (Status restored = scene_.scene_.restore(std::move(content)); !restored) return restored;
    auto kept = scene_.recent_.drop_all();
    scene_.forget(kept);
    if (before->node_count() > 0)
      scene_.past_.add(*before,
                       scene_.memory_.record(exec::Held::kRevisions, scene_.nodes_.bytes()));
    scene_.log_.begin_after(revision);
    scene_.name_bytes_ = names;
    scene_.nodes_ = std::move(*charge);
    return {};
  }

  Status batch(std::uint64_t revision, std::vector<scenegraph::model::Update> updates,
               const std::vector<scenegraph::model::NodeId>& nodes) override {
    const auto applied = scene_.replay(std::move(updates));
    if (!applied && applied.error().code == Code::kResourceExhausted) return applied.error();
    if (!applied) return corrupt(revision, applied.error().message);
    if (applied->revision == revision && applied->nodes == nodes) return {};
    return corrupt(revision, fmt::format("it makes revision {} and other nodes than it did before",
                                         applied->revision));
  }

  Status answer(const std::string& request_id, std::uint64_t content,
                const scenegraph::Applied& applied) override {
    if (again_) return {};  // SceneFollower::look_up() reads what is asked for
    scene_.answers_.retain(scene_.answers_.prepare(request_id, content, applied));
    return {};
  }

  Status producer(const std::string& name, std::uint64_t last_committed,
                  std::vector<ProducerBatch> recent) override {
    if (again_) return {};
    const auto producer = scene_.producers_.open(name);
    if (!producer) return producer.error();
    scene_.set_progress(**producer, {last_committed, std::move(recent)});
    return {};
  }

 private:
  Error corrupt(std::uint64_t revision, const std::string& why) const {
    return {Code::kDataLoss,
            fmt::format("{} cannot be read beyond revision {}: its next batch is corrupt: {}",
                        scene_.info_.name, revision - 1, why),
            "STORE_CORRUPT"};
  }

  StoredScene& scene_;
  const bool again_;
};

void StoredScene::set_progress(Producer& producer, KeptProducer kept) {
  producer.put.trim_to(0).clear();
  producer.put.reserve_more(kept.recent.size());
  for (ProducerBatch& batch : kept.recent) {
    const std::size_t bytes = batch.nodes.size() * sizeof(scenegraph::model::NodeId);
    producer.commit(
        {batch.sequence, std::move(batch.nodes), memory_.record(exec::Held::kLogs, bytes)});
  }
  producer.last_committed = kept.last_committed;
}

Status StoredScene::read_on() {
  Loader loader(*this);
  return journal_->follow(scene_.snapshot()->revision(), loader);
}

Status StoredScene::read_again() {
  Loader loader(*this, true);
  Status read = journal_->load(loader);
  events_.notify();
  return read;
}

Status StoredScene::load(exec::Compute& compute) {
  if (loaded()) return {};
  const std::lock_guard lock(loading_);
  if (loaded()) return {};
  if (failed()) return read_;  // SceneStore::get() replaces it: this one has a part of its batches
  if (Status fits = memory_.reclaim(exec::Held::kNodes, unread_bytes_); !fits) return fits;
  compute_.store(&compute, std::memory_order_release);
  const Clock::time_point begun = Clock::now();
  Loader loader(*this);
  read_ = exec::to_status([&] { return journal_->load(loader); });
  if (!read_) {
    failed_.store(true, std::memory_order_release);
    spdlog::error("event=scene_not_loaded scene={} error={}", info_.name, read_.error().message);
    return read_;
  }
  loaded_.store(true, std::memory_order_release);
  const auto time = std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - begun);
  spdlog::info("event=scene_loaded scene={} revision={} ms={}", info_.name,
               scene_.snapshot()->revision(), time.count());
  return {};
}

}  // namespace sightline::server::scenes
