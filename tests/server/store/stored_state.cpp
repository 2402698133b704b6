// All that a store answers, to compare before and after damage.
#include "tests/server/store/stored_state.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <array>

#include "tests/server/store/store_steps.h"

namespace sightline::tests {
namespace {

namespace store = server::store;
using Text = Result<std::string>;

constexpr std::uint64_t kBatches = 12;
constexpr std::uint64_t kFirstSnapshot = 4;
constexpr std::uint64_t kSecondSnapshot = 8;
constexpr std::array<const char*, 2> kNames{"projects/p/scenes/a", "projects/p/scenes/b"};

void fill_scene(store::Store& store, const std::string& name, int number) {
  const auto id = store.create_scene({.name = name,
                                      .incarnation = 100 + static_cast<std::uint64_t>(number),
                                      .up_axis = store::UpAxis::kZ,
                                      .meters_per_unit = 0.5 + number});
  ASSERT_TRUE(id.ok());
  const std::string bytes = blob_bytes(number);
  ASSERT_TRUE(store_blob(store, bytes).ok());
  for (std::uint64_t i = 0; i < kBatches; ++i) {
    store::Batch batch{*id, i,  fmt::format("update {} of {} {:0>{}}", i, name, "", 200 * (i % 3)),
                       {},  {}, {}};
    if (i % 3 == 0) batch.blobs = {digest_of_blob(bytes)};
    batch.answer =
        store::RequestAnswer{fmt::format("request {}", i), i * 77, i + 1, {i + 1, i + 9}};
    batch.commits = {{i % 2 == 0 ? "robot" : "camera", i + 1, {i + 1}}};
    ASSERT_TRUE(tests::append(store, std::move(batch)).ok());
  }
  for (const std::uint64_t revision : {kFirstSnapshot, kSecondSnapshot})
    ASSERT_TRUE(put_snapshot(store, *id, revision, {"nodes of ", name, std::to_string(revision)},
                             {digest_of_blob(bytes)})
                    .ok());
  ASSERT_TRUE(store.drop_before(*id, kFirstSnapshot).ok());
}

/// The text of what a call has returned.
template <class T, class Write>
Text as_text(const Result<T>& result, const Write& write) {
  if (!result) return result.error();
  return write(*result);
}

std::string text_of(const store::RequestAnswer& answer) {
  return fmt::format("{} {} {} {}", answer.request_id, answer.content, answer.revision,
                     answer.nodes);
}

std::string text_of(const store::ProducerRecord& producer) {
  std::string text = fmt::format("{} {}", producer.name, producer.last_committed);
  for (const auto& one : producer.recent) text += fmt::format(" {} {}", one.sequence, one.nodes);
  return text;
}

template <class Items>
std::string text_of_all(const Items& items) {
  std::string text;
  for (const auto& item : items) text += text_of(item) + "\n";
  return text;
}

void add_scene(store::Store& store, store::SceneId id, std::map<std::string, Text>& state) {
  const auto key = [id](const char* what) { return fmt::format("{} {}", what, id); };
  state.emplace(key("record"), as_text(store.scene(id), [](const store::SceneRecord& record) {
                  return fmt::format(
                      "{} {} {} {} {} {}", record.info.name, static_cast<int>(record.info.up_axis),
                      record.info.meters_per_unit, record.revision, record.base, record.log_bytes);
                }));
  state.emplace(key("log"), as_text(log_of(store, id, kFirstSnapshot), [](const auto& log) {
                  return fmt::format("{}", fmt::join(log, "\n"));
                }));
  for (std::uint64_t chunk = 0; chunk < 4; ++chunk)
    state.emplace(fmt::format("chunk {} {}", id, chunk),
                  store.read_snapshot(id, kFirstSnapshot, chunk));
  state.emplace(key("answers"),
                as_text(store.answers(id), [](const auto& all) { return text_of_all(all); }));
  state.emplace(key("producers"),
                as_text(store.producers(id), [](const auto& all) { return text_of_all(all); }));
}

}  // namespace

void fill_store(store::Store& store) {
  const auto removed = store.create_scene({.name = "projects/p/scenes/c", .incarnation = 99});
  ASSERT_TRUE(removed.ok());
  ASSERT_TRUE(tests::append(store, *removed, 0, "of a scene that is removed").ok());
  for (std::size_t i = 0; i < kNames.size(); ++i) fill_scene(store, kNames[i], static_cast<int>(i));
  ASSERT_TRUE(store.remove_scene(*removed).ok());
  store.flush();
}

std::map<std::string, Text> state_of(store::Store& store) {
  std::map<std::string, Text> state;
  state.emplace("names", as_text(store.scenes(), [](const auto& scenes) {
                  std::string names;
                  for (const store::SceneRecord& scene : scenes)
                    if (!scene.damaged) names += scene.info.name + "\n";
                  return names;
                }));
  for (const char* name : kNames) {
    const auto found = store.find_scene(name);
    state.emplace(std::string("named ") + name, as_text(found, [](const auto& scene) {
                    return scene ? std::to_string(scene->id) : std::string("none");
                  }));
  }
  for (const store::SceneId id : {2, 3}) add_scene(store, id, state);
  for (int i = 0; i < 2; ++i)
    state.emplace(fmt::format("blob {}", i), load_blob(store, digest_of_blob(blob_bytes(i))));
  return state;
}

}  // namespace sightline::tests
