// Keeps scenes in a store.
#include "server/durable/store_keeper.h"

#include <memory>
#include <utility>

#include "server/durable/store_journal.h"

namespace sightline::server::durable {
namespace {

static_assert(static_cast<int>(scenes::UpAxis::kZ) == static_cast<int>(store::UpAxis::kZ));

}  // namespace

Result<scenes::KeptScene> StoreKeeper::create(const scenes::SceneInfo& info) {
  const std::uint64_t incarnation = scenes::new_incarnation();
  const auto id = parts_.store.create_scene(
      {info.name, incarnation, static_cast<store::UpAxis>(info.up_axis), info.meters_per_unit});
  if (!id) return id.error();
  store::SceneRecord record;
  record.id = *id;
  return scenes::KeptScene{std::make_shared<StoreJournal>(parts_, record), incarnation, false};
}

Result<std::vector<scenes::SceneKeeper::Found>> StoreKeeper::find_all() {
  const auto records = parts_.store.scenes();
  if (!records) return records.error();
  std::vector<Found> found;
  found.reserve(records->size());
  for (const store::SceneRecord& record : *records) {
    found.push_back({{record.info.name, static_cast<scenes::UpAxis>(record.info.up_axis),
                      record.info.meters_per_unit},
                     {std::make_shared<StoreJournal>(parts_, record), record.info.incarnation, true}});
  }
  return found;
}

}  // namespace sightline::server::durable
