// A scene's journal in a store: the update log, and all nodes from time to time.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/durable/nodes_codec.h"
#include "server/durable/store_catalog.h"
#include "server/scenes/journal.h"
#include "server/store/store.h"

namespace sightline::server::durable {

/// Writes a snapshot of all nodes when the log since the last one has as many bytes as that had.
/// Must be made by std::make_shared.
class StoreJournal final : public scenes::Journal,
                           public std::enable_shared_from_this<StoreJournal> {
 public:
  StoreJournal(const StoreParts& parts, const store::SceneRecord& record);

  Status load(scenes::JournalReader& into) override;
  Status follow(std::uint64_t revision, scenes::JournalReader& into) override;
  Result<std::optional<scenes::KeptAnswer>> answer(const std::string& request_id) override;
  Result<std::optional<scenes::KeptProducer>> producer(const std::string& name) override;
  std::string encode(const std::vector<scenegraph::model::Update>& updates,
                     const std::vector<scenegraph::model::NodeId>& nodes) const override;
  Result<std::vector<scenegraph::model::Update>> decode(const std::string& updates) override;
  Status append(const scenes::JournalEntry& entry, Done done) override;
  void published(const scenegraph::SceneState& newest, std::uint64_t oldest) noexcept override;
  Status remove() override;

 private:
  Status load_base(const store::SceneRecord& record, scenes::JournalReader& into);
  Status load_log(std::uint64_t base, scenes::JournalReader& into);
  Status load_writers(scenes::JournalReader& into);
  Status write_snapshot(const scenegraph::SceneState& state, std::uint64_t oldest);
  void note_failure(std::uint64_t revision, const Error& error);
  Result<std::uint64_t> write_parts(NodesWriter& writer, std::uint64_t revision);
  Status move_base(std::uint64_t oldest);

  const StoreParts parts_;
  const store::SceneId id_;
  std::atomic<std::uint64_t> log_bytes_;     // updates since the last snapshot
  std::atomic<std::uint64_t> last_cost_{0};  // bytes of the last snapshot
  std::atomic<bool> writing_{false};         // a task writes a snapshot
};

}  // namespace sightline::server::durable
