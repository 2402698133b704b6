// Scenes in memory.
#include "server/scenes/scene_store.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace sightline::server::scenes {
namespace {

std::vector<std::string> names_of(const ScenePage& page) {
  std::vector<std::string> names;
  for (const auto& scene : page.scenes) names.push_back(scene->info().name);
  return names;
}

TEST(SceneStore, CreatesGetsAndRemoves) {
  exec::MemoryAccount memory(std::uint64_t{1} << 30);
  SceneStore store(memory);
  ASSERT_TRUE(store.create({"projects/p/scenes/s", UpAxis::kZ, 0.5}));
  const auto found = store.get("projects/p/scenes/s");
  ASSERT_TRUE(found);
  EXPECT_EQ((*found)->info().up_axis, UpAxis::kZ);
  EXPECT_EQ(store.create({"projects/p/scenes/s"}).error().code, Code::kAlreadyExists);
  EXPECT_TRUE(store.remove("projects/p/scenes/s"));
  EXPECT_EQ(store.get("projects/p/scenes/s").error().code, Code::kNotFound);
  EXPECT_EQ(store.remove("projects/p/scenes/s").error().code, Code::kNotFound);
}

TEST(SceneStore, ListsAProjectInPages) {
  exec::MemoryAccount memory(std::uint64_t{1} << 30);
  SceneStore store(memory);
  for (const char* name :
       {"projects/p/scenes/b", "projects/p/scenes/a", "projects/p/scenes/c",
        "projects/p-1/scenes/x", "projects/p1/scenes/y", "projects/q/scenes/z"}) {
    ASSERT_TRUE(store.create({name}));
  }
  const ScenePage first = store.list("projects/p", "", 2);
  EXPECT_EQ(names_of(first),
            (std::vector<std::string>{"projects/p/scenes/a", "projects/p/scenes/b"}));
  EXPECT_EQ(first.next, "projects/p/scenes/b");
  const ScenePage second = store.list("projects/p", first.next, 2);
  EXPECT_EQ(names_of(second), (std::vector<std::string>{"projects/p/scenes/c"}));
  EXPECT_EQ(second.next, "");
  EXPECT_EQ(store.list("projects/p", "", 3).next, "") << "a full last page has no next";
  EXPECT_TRUE(store.list("projects/none", "", 3).scenes.empty());
}

TEST(SceneStore, IsBounded) {
  exec::MemoryAccount memory(std::uint64_t{1} << 30);
  SceneStore store(memory);
  for (std::size_t i = 0; i < SceneStore::kMaxScenes; ++i) {
    ASSERT_TRUE(store.create({"projects/p/scenes/" + std::to_string(i)}));
  }
  EXPECT_EQ(store.create({"projects/p/scenes/one-more"}).error().code, Code::kResourceExhausted);
}

}  // namespace
}  // namespace sightline::server::scenes
