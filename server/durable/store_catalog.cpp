// Creates, restores and finds scenes in a store.
#include "server/durable/store_catalog.h"

#include <spdlog/spdlog.h>

#include <memory>
#include <optional>
#include <utility>

#include "server/durable/store_journal.h"

namespace sightline::server::durable {
namespace {

static_assert(static_cast<int>(scenes::UpAxis::kZ) == static_cast<int>(store::UpAxis::kZ));

store::SceneInfo stored_info(const scenes::SceneInfo& info) {
  return {info.name, scenes::new_incarnation(), static_cast<store::UpAxis>(info.up_axis),
          info.meters_per_unit};
}

}  // namespace

Result<scenes::KeptScene> StoreCatalog::create(const scenes::SceneInfo& info) {
  const store::SceneInfo stored = stored_info(info);
  const auto id = parts_.store.create_scene(stored);
  if (!id) return id.error();
  store::SceneRecord record;
  record.id = *id;
  return scenes::KeptScene{std::make_shared<StoreJournal>(parts_, record), stored.incarnation,
                           std::nullopt, *id, replica_};
}

Result<scenes::KeptScene> StoreCatalog::restore(const scenes::SceneInfo& info,
                                                const scenegraph::SceneState& state, bool replace) {
  NodesWriter writer(state);
  if (const auto kept = writer.keep_patched(parts_.blobs); !kept) return kept.error();
  const store::SceneInfo stored = stored_info(info);
  const auto id = parts_.store.restore_scene(
      stored, state.snapshot->revision(), writer.blobs(),
      [&]() -> Result<std::string> { return writer.next(kPartBytes); }, replace);
  if (!id) return id.error();
  const auto record = parts_.store.scene(*id);
  if (!record) return record.error();
  return found(*record).kept;
}

Result<std::vector<scenes::SceneCatalog::Found>> StoreCatalog::find_all() {
  const auto records = parts_.store.scenes();
  if (!records) return records.error();
  std::vector<Found> all;
  all.reserve(records->size());
  for (const store::SceneRecord& record : *records) {
    if (record.damaged)
      spdlog::error("event=scene_damaged scene={} number={}", record.info.name, record.id);
    all.push_back(found(record));
  }
  return all;
}

Result<std::optional<scenes::SceneCatalog::Found>> StoreCatalog::find(const std::string& name) {
  const auto record = parts_.store.find_scene(name);
  if (!record) return record.error();
  if (!*record) return std::optional<Found>();
  return std::optional(found(**record));
}

Result<scenes::SceneCatalog::Found> StoreCatalog::find(store::SceneId id) {
  const auto record = parts_.store.scene(id);
  if (!record) return record.error();
  return found(*record);
}

scenes::SceneCatalog::Found StoreCatalog::found(const store::SceneRecord& record) const {
  return {{record.info.name, static_cast<scenes::UpAxis>(record.info.up_axis),
           record.info.meters_per_unit},
          {std::make_shared<StoreJournal>(parts_, record), record.info.incarnation, record.revision,
           record.id, replica_}};
}

}  // namespace sightline::server::durable
