// The scenes of the server by name.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/scenes/stored_scene.h"

namespace sightline::server::scenes {

/// A part of a list of scenes.
struct ScenePage {
  std::vector<std::shared_ptr<StoredScene>> scenes;  ///< By name.
  std::string next;  ///< The last name of this page if more follow, else empty.
};

/// The caller checks names (server/scenes/names.h). Threads: any, for every member. A
/// pointer to a scene keeps it alive after its removal.
class SceneStore {
 public:
  static constexpr std::size_t kMaxScenes = 10'000;

  /// Scenes are charged to `memory`. `catalog` keeps them beyond the process; null: nothing does.
  /// Both outlive this object.
  explicit SceneStore(exec::MemoryAccount& memory, SceneCatalog* catalog = nullptr)
      : memory_(memory), catalog_(catalog) {}

  /// Finds the scenes that are kept. They are loaded when they are used. Call it first. Errors: as
  /// SceneCatalog::find_all.
  Status open();

  /// Waits for the disk, where scenes are kept. Errors: kAlreadyExists, kResourceExhausted (too
  /// many scenes, or no room for it in the memory budget), as SceneCatalog::create.
  Result<std::shared_ptr<StoredScene>> create(SceneInfo info);
  /// A scene with these nodes, in place of the one of its name, if there is one. Waits for the
  /// disk. Errors: kFailedPrecondition (scenes are not kept), kResourceExhausted, as
  /// SceneCatalog::restore.
  Result<std::shared_ptr<StoredScene>> restore(const SceneInfo& info,
                                               const scenegraph::SceneState& state);
  /// A scene that has no name yet: put() gives it one.
  std::shared_ptr<StoredScene> draft(SceneInfo info) const {
    return std::make_shared<StoredScene>(std::move(info), memory_);
  }
  /// Whether put() would take a scene of this name now. Errors: as put().
  Status check_put(const std::string& name, bool replace) const;
  /// Names a draft, at its newest revision, in one step. With `replace` it takes the place of a
  /// scene of its name, whose listeners are called. Returns the scene, which may not be loaded; the
  /// draft must not be used any more. Waits for the disk. Errors: kAlreadyExists,
  /// kResourceExhausted, as SceneCatalog::restore.
  Result<std::shared_ptr<StoredScene>> put(const std::shared_ptr<StoredScene>& draft, bool replace);
  /// The scene, which may not be loaded. If it is not, the store is asked whether another server
  /// has made or replaced it. Errors: kNotFound, as look_up().
  Result<std::shared_ptr<StoredScene>> get(const std::string& name);
  /// Whether a list shows the scene of this name. Must be short and call no member of the store.
  using Shown = std::function<bool(const std::string& name)>;
  /// Up to `limit` scenes of "projects/{project}", or of kAllProjects, whose names come after
  /// `after` (empty: from the first) and that are shown; without `shown` all are.
  ScenePage list(const std::string& project, const std::string& after, std::size_t limit,
                 const Shown& shown = {}) const;
  /// Calls the listeners of the scene. Waits for the disk, where scenes are kept. Errors:
  /// kNotFound, as Journal::remove.
  Status remove(const std::string& name);

  // These members are for a store that other servers use, too; elsewhere they do nothing.

  /// Asks which scene has this name now. Waits for the store. Errors: kUnavailable, where the store
  /// is away; as SceneCatalog::find.
  Status look_up(const std::string& name);
  /// Takes a scene that another server has made, unless it is known, or older than the one of its
  /// name, which is removed.
  void adopt(SceneCatalog::Found found);
  /// Removes a scene that another server has removed.
  void forget(const std::shared_ptr<StoredScene>& scene);
  /// All scenes, by number.
  std::map<store::SceneId, std::shared_ptr<StoredScene>> by_number() const;

  /// Unloads the scene at which rays were cast longest ago, of those that are kept, that no call
  /// uses and for which stays() is false. The next call reads it again, as after a restart. Returns
  /// whether there was one.
  bool unload_one(const std::function<bool(const StoredScene&)>& stays = {});
  /// How many scenes unload_one() has unloaded.
  std::uint64_t unloaded() const { return unloaded_.load(); }

  /// Calls StoredScene::retry_writes() of all scenes.
  void retry_writes() const;
  /// Calls StoredScene::flush() of all scenes.
  void flush(StoredScene::Clock::time_point until) const;

  /// All scenes, those first at which rays were cast longest ago.
  std::vector<std::shared_ptr<StoredScene>> by_last_cast() const;

 private:
  Result<std::shared_ptr<StoredScene>> find(const std::string& name) const;
  Status look_up_while_changing(const std::string& name);
  void adopt_while_changing(SceneCatalog::Found found);
  void forget_while_changing(const std::shared_ptr<StoredScene>& scene);
  void publish(const std::shared_ptr<StoredScene>& scene);
  Status check_number() const;

  exec::MemoryAccount& memory_;
  SceneCatalog* const catalog_;
  std::atomic<std::uint64_t> unloaded_{0};
  std::mutex changing_;  // held while a scene is created or removed
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<StoredScene>> scenes_;
};

}  // namespace sightline::server::scenes
