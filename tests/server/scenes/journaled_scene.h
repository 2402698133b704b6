// A scene whose writes a journal keeps, for tests.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <future>
#include <memory>

#include "server/scenes/replica.h"
#include "server/scenes/stored_scene.h"
#include "tests/server/scenes/fake_journal.h"

namespace sightline::tests {

class JournaledScene : public testing::Test {
 protected:
  /// `replica`: of a scene to which other servers write, too.
  explicit JournaledScene(std::shared_ptr<server::scenes::Replica> replica = nullptr)
      : replica_(std::move(replica)) {}
  /// What is queued owns the scene, and the scene owns the queue.
  ~JournaledScene() override {
    while (journal_->queued() > 0) commit();
  }

  /// Runs the task on the write queue and waits for it, and for all tasks before it.
  void on_queue(const std::function<void()>& task) {
    std::promise<void> done;
    scene_->write_queue().post(compute_, [&] {
      task();
      done.set_value();
    });
    done.get_future().wait();
  }
  void commit() {
    journal_->commit();
    on_queue([] {});
  }
  std::uint64_t revision() const { return scene_->snapshot()->revision(); }

  server::exec::MemoryAccount memory_{std::uint64_t{1} << 30};
  const std::shared_ptr<FakeJournal> journal_ = std::make_shared<FakeJournal>();
  const std::shared_ptr<server::scenes::Replica> replica_;
  std::shared_ptr<server::scenes::StoredScene> scene_ =
      std::make_shared<server::scenes::StoredScene>(
          server::scenes::SceneInfo{.name = "projects/p/scenes/s"}, memory_,
          server::scenes::KeptScene{journal_, 7, {}, 1, replica_});
  server::exec::Compute compute_{1};
};

}  // namespace sightline::tests
