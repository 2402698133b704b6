// Threads that expand one cell together: equal cuts, little duplicate work, and no waiting for a
// thread that has stopped.
#include "accel/lazy/passes.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "accel/kdtree/tree_metrics.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/lazy/split_tree.h"
#include "accel/published/any_builder.h"
#include "tests/accel/boxes.h"
#include "tests/accel/check_tree.h"
#include "tests/accel/lazy/gate.h"
#include "tests/support/sleep_shortly.h"

namespace sightline::accel::lazy {
namespace {

PassSlice counted(std::size_t references) {
  PassSlice result;
  result.straddling.all = references;
  return result;
}

TEST(Passes, AThreadFindsThePassesThatAreDone) {
  auto* chain = new PassChain(nullptr);
  std::atomic<int> runs{0};
  const auto follow = [&](kdtree::BuildCounters& counters) {
    Passes passes(*chain, counters, nullptr);
    std::size_t sum = 0;
    for (std::size_t k = 1; k <= 4; ++k) {
      const auto work = [&runs, k](std::size_t slice, kdtree::BuildCounters&) {
        ++runs;
        return counted(k * slice);
      };
      passes.run(k, work, [&](const PassSlice& slice) { sum += slice.straddling.all; });
    }
    return sum;
  };
  kdtree::BuildCounters counters;
  const std::size_t first = follow(counters);
  EXPECT_EQ(runs, 1 + 2 + 3 + 4);
  const std::uint64_t progress = chain->progress();
  EXPECT_EQ(follow(counters), first);
  EXPECT_EQ(runs, 1 + 2 + 3 + 4);
  EXPECT_EQ(chain->progress(), progress);
  chain->leave();
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
    return std::make_unique<LazyTree>(kdtree::bounds_of(*refs), refs->size(), split::default_rule(),
                                      source);
  }
};

/// Calls to idle threads may run late: this waits for them when its trees are gone. At the end of a
/// process they would count as leaks.
struct SharedBoxes : ManyBoxes {
  using ManyBoxes::ManyBoxes;
  ~SharedBoxes() {
    while (refs.use_count() > 1) {
      kdtree::reclaim();
      std::this_thread::yield();
    }
  }
  SharedBoxes(const SharedBoxes&) = delete;
  SharedBoxes& operator=(const SharedBoxes&) = delete;
};

/// Expands the cells on the way to the first reference, as a ray would.
kdtree::BuildCounters descend(LazyTree& tree, const geometry::Vec3f& point) {
  const kdtree::EpochPin pin;
  kdtree::BuildCounters counters;
  for (kdtree::AtomicSlot* at = &tree.root(); at != nullptr;) {
    const kdtree::Slot slot = kdtree::load(*at);
    if (slot.is_deferred()) {
      if (tree.expand(*at, counters) == AtCell::kSearch) break;
      continue;
    }
    at = nullptr;
    for (std::size_t i = 0; slot.is_node() && i < kdtree::kWidth && slot.node()->child(i); ++i) {
      if (tests::holds_point(tests::box_of(*slot.node(), i, tree.frame()), point))
        at = &slot.node()->slot(i);
    }
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

TEST(Passes, SixteenThreadsInOneColdCellBuildWhatOneBuilds) {
  const SharedBoxes boxes(400'000);
  const geometry::Vec3f point = (*boxes.refs)[0].lo;
  const auto alone = boxes.tree(), together = boxes.tree();
  const std::uint64_t one = descend_with(1, *alone, point);
  // How much of the work is done twice depends on which threads the system suspends.
  EXPECT_GE(descend_with(16, *together, point), one);
  const kdtree::EpochPin pin;
  const kdtree::Slot root = kdtree::load(together->root()), other = kdtree::load(alone->root());
  ASSERT_TRUE(root.is_node() && other.is_node());
  EXPECT_EQ(root.node()->bounds, other.node()->bounds);
  const auto cells = [](const LazyTree& t) {
    return measure_growth(t.tree(), 400'000).cells_built;
  };
  EXPECT_EQ(cells(*together), cells(*alone));
}

TEST(Passes, AThreadStoppedInASliceDoesNotDelayOthers) {
  for (int stopped_at : {0, 7, 40}) {
    auto gate = std::make_shared<Gate>();
    SharedBoxes boxes(200'000);
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

TEST(Passes, ACancelledThreadLeavesAfterASliceAndTheNextOneGoesOn) {
  // A helper may be in a slice while this thread is cancelled.
  const oneapi::tbb::global_control alone(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  ManyBoxes boxes(400'000);
  const auto slices = std::make_shared<std::atomic<int>>(0);
  const auto cancelled = std::make_shared<std::atomic<bool>>(false);
  boxes.at_slice = [slices, cancelled] {
    if (++*slices == 3) *cancelled = true;
  };
  const auto tree = boxes.tree();
  kdtree::BuildCounters counters;
  {
    const kdtree::EpochPin pin;
    EXPECT_EQ(tree->expand(tree->root(), counters, cancelled.get()), AtCell::kSearch);
    EXPECT_TRUE(kdtree::load(tree->root()).is_deferred());
  }
  EXPECT_EQ(*slices, 3) << "none after the one that was cancelled";
  EXPECT_EQ(counters.cells_expanded, 0u);
  const auto other = ManyBoxes(400'000).tree();
  const geometry::Vec3f point = (*boxes.refs)[0].lo;
  EXPECT_EQ(descend(*tree, point).cells_expanded, descend(*other, point).cells_expanded);
}

TEST(Passes, AFullBuildThatIsCancelledWithinTheListOfARootReturns) {
  ManyBoxes boxes(kSampleFrom - 1);  // two slices, which one thread lists
  const auto cancelled = std::make_shared<std::atomic<bool>>(false);
  boxes.at_slice = [cancelled] { *cancelled = true; };
  const auto tree = boxes.tree();
  kdtree::BuildCounters counters;
  tree->expand_all(counters, cancelled.get());
  EXPECT_FALSE(tree->is_complete());
  EXPECT_EQ(counters.cells_expanded, 0u);
  tree->expand_all(counters);
  EXPECT_TRUE(tree->is_complete());
}

/// Does the slices of a chain's last pass, as a called thread does.
void help(PassChain& chain) {
  kdtree::BuildCounters counters;
  chain.help(counters);
  chain.leave();
}

TEST(Passes, KeepsTheSourceAliveForAStoppedHelper) {
  auto source = std::make_shared<int>(0);
  const std::weak_ptr<int> watched = source;
  Gate gate;
  auto* const chain = new PassChain(std::move(source));
  // In an arena for one thread, no other is called.
  tbb::task_arena(1).execute([&] {
    chain->pass_after(nullptr, 2, [&gate](std::size_t slice, kdtree::BuildCounters&) {
      gate.pass();
      return counted(slice);
    });
  });
  chain->join();
  std::thread helper([chain] { help(*chain); });
  while (!gate.taken()) tests::sleep_shortly();
  chain->leave();
  EXPECT_FALSE(watched.expired()) << "the stopped helper still reads it";
  gate.open();
  helper.join();
  EXPECT_TRUE(watched.expired());
}

TEST(Passes, CalledThreadsReleaseTheSourceOfATreeThatIsGone) {
  std::weak_ptr<const void> source;
  tbb::task_arena arena(4);
  arena.execute([&] {
    const ManyBoxes boxes(70'000);
    source = boxes.refs;
    descend(*boxes.tree(), (*boxes.refs)[0].lo);
  });
  // Calls may run long after all slices are done; if they did not, the test would hang.
  while (!source.expired()) {
    kdtree::reclaim();
    tests::sleep_shortly();
  }
}

}  // namespace
}  // namespace sightline::accel::lazy
