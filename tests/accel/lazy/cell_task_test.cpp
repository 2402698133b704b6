// Threads that expand one cell together: equal cuts, little duplicate work, and no waiting for a
// thread that has stopped.
#include "accel/lazy/cell_task.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "accel/kdtree/tree_metrics.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/published/any_builder.h"
#include "tests/accel/boxes.h"
#include "tests/accel/check_tree.h"
#include "tests/accel/lazy/gate.h"

namespace sightline::accel::lazy {
namespace {

std::unique_ptr<PassSlice> counted(std::size_t references) {
  auto result = std::make_unique<PassSlice>();
  result->straddling.all = references;
  return result;
}

TEST(CellTask, APassSequenceFindsThePassesThatAreDone) {
  auto* task = new CellTask(nullptr);
  std::atomic<int> runs{0};
  const auto follow = [&](kdtree::BuildCounters& counters) {
    PassSequence passes(*task, counters);
    std::size_t sum = 0;
    for (std::size_t k = 1; k <= 4; ++k) {
      const SharedPass& pass =
          passes.next(k, [&runs, k](std::size_t slice, kdtree::BuildCounters&) {
            ++runs;
            return counted(k * slice);
          });
      for (std::size_t i = 0; i < pass.slices(); ++i) sum += pass[i].straddling.all;
    }
    return sum;
  };
  kdtree::BuildCounters counters;
  const std::size_t first = follow(counters);
  EXPECT_EQ(runs, 1 + 2 + 3 + 4);
  const std::uint64_t progress = task->progress();
  EXPECT_EQ(follow(counters), first);
  EXPECT_EQ(runs, 1 + 2 + 3 + 4);
  EXPECT_EQ(task->progress(), progress);
  task->leave();
}

/// A tree over many small boxes whose list is made in slices.
struct ManyBoxes {
  std::shared_ptr<const std::vector<kdtree::Reference>> refs;
  std::function<void()> at_slice = [] {};

  explicit ManyBoxes(std::size_t count)
      : refs(std::make_shared<const std::vector<kdtree::Reference>>(
            tests::random_boxes(count, 0.002, 5))) {}

  std::unique_ptr<LazyTree> tree() const {
    ReferenceSource source;
    source.coarsest = [count = refs->size()](kdtree::BuildCounters&) {
      return ReferenceSource::Coarsest{.slots = count};
    };
    source.list = [refs = refs, at_slice = at_slice](std::size_t begin, std::size_t end,
                                                     kdtree::Reference* out,
                                                     kdtree::BuildCounters&) {
      if (end - begin > 1) at_slice();  // Or one thread takes a sample
      std::copy(refs->data() + begin, refs->data() + end, out);
      return end - begin;
    };
    source.alive = refs;
    return std::make_unique<LazyTree>(tests::bounds_of(*refs), refs->size(), split::default_rule(),
                                      source);
  }
};

/// Expands the cells on the way to the first reference, as a ray would.
kdtree::BuildCounters descend(LazyTree& tree, const geometry::Vec3f& point) {
  const kdtree::EpochPin pin;
  kdtree::BuildCounters counters;
  kdtree::AtomicSlot* at = &tree.root();
  for (kdtree::Slot slot = kdtree::load(*at); !slot.is_leaf(); slot = kdtree::load(*at)) {
    if (slot.is_deferred()) {
      if (tree.expand(*at, WhenPending::kWait, counters) == ExpandResult::kScanList) break;
      continue;
    }
    const auto axis = static_cast<std::size_t>(slot.axis());
    at = &tree.tree().children(slot)[point[axis] < slot.position() ? 0 : 1];
  }
  return counters;
}

std::uint64_t descend_with(int threads, LazyTree& tree, const geometry::Vec3f& point) {
  std::atomic<std::uint64_t> touches{0};
  std::vector<std::thread> pool;
  for (int i = 0; i < threads; ++i)
    pool.emplace_back([&] { touches += descend(tree, point).touches; });
  for (std::thread& t : pool) t.join();
  return touches;
}

TEST(CellTask, SixteenThreadsInOneColdCellDuplicateLittleWork) {
  const ManyBoxes boxes(400'000);
  const geometry::Vec3f point = (*boxes.refs)[0].lo;
  const auto alone = boxes.tree(), together = boxes.tree();
  const auto one = static_cast<double>(descend_with(1, *alone, point));
  const auto many = static_cast<double>(descend_with(16, *together, point));
  EXPECT_GE(many, one);
  EXPECT_LE(many, 1.05 * one);
  std::vector<geometry::Aabb> bounds;
  for (const kdtree::Reference& ref : *boxes.refs) bounds.push_back(ref.bounds());
  const kdtree::EpochPin pin;
  EXPECT_EQ(kdtree::load(together->root()).position(), kdtree::load(alone->root()).position());
  const auto cells = [](const LazyTree& t) {
    return measure_growth(t.tree(), 400'000).cells_built;
  };
  EXPECT_EQ(cells(*together), cells(*alone));
}

TEST(CellTask, AThreadStoppedInASliceDoesNotDelayOthers) {
  for (int stopped_at : {0, 7, 40}) {
    auto gate = std::make_shared<Gate>();
    ManyBoxes boxes(200'000);
    auto slices = std::make_shared<std::atomic<int>>(0);
    boxes.at_slice = [gate, slices, stopped_at] {
      if ((*slices)++ == stopped_at) gate->pass();
    };
    const geometry::Vec3f point = (*boxes.refs)[0].lo;
    const auto tree = boxes.tree();
    std::vector<std::thread> threads;
    std::atomic<int> through{0};
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&] {
        descend(*tree, point);
        ++through;
        through.notify_all();
      });
    }
    // All but the thread at the gate; otherwise the test would hang.
    for (int now = through; now < 3; now = through) through.wait(now);
    gate->open();
    for (std::thread& t : threads) t.join();
    EXPECT_EQ(through, 4);
  }
}

/// Waits for a condition that becomes true, or never does: the limit only ends a failing test.
template <class Condition>
bool happens(Condition condition) {
  const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > limit) return false;
    std::this_thread::yield();
  }
  return true;
}

TEST(CellTask, OutlivesItsTree) {
  std::atomic<bool> helper_stopped{false}, may_continue{false}, helped{true};
  std::weak_ptr<const void> source;
  const auto caller = std::this_thread::get_id();
  const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
  tbb::task_arena arena(2);
  arena.execute([&] {
    ManyBoxes boxes(70'000);
    source = boxes.refs;
    // A helper thread stops in its first slice; the caller runs none before.
    boxes.at_slice = [&] {
      if (std::this_thread::get_id() == caller) {
        helped = helped && happens([&] { return helper_stopped.load(); });
      } else if (!helper_stopped.exchange(true)) {
        while (!may_continue) std::this_thread::yield();
      }
    };
    const auto tree = boxes.tree();
    descend(*tree, (*boxes.refs)[0].lo);
  });
  ASSERT_TRUE(helped) << "no helper thread ran";
  kdtree::reclaim();
  EXPECT_FALSE(source.expired()) << "the stopped thread still reads it";
  may_continue = true;
  EXPECT_TRUE(happens([&] {
    kdtree::reclaim();
    return source.expired();
  }));
}

}  // namespace
}  // namespace sightline::accel::lazy
