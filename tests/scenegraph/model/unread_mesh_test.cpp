// Meshes whose arrays are read when a ray, a build or an update first needs them.
#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <thread>
#include <utility>

#include "scenegraph/model/mesh.h"
#include "scenegraph/query/build.h"
#include "scenegraph/revision/deferred_cells.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/kinds.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph::model {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;

/// What a source has been asked for.
struct Asked {
  std::atomic<int> reads{0}, charged{0}, without_reclaim{0};
  std::optional<Error> charge_error, read_error;
  std::function<void()> while_read;
};

class TestSource final : public MeshSource {
 public:
  TestSource(std::shared_ptr<const Mesh> mesh, Asked& asked)
      : mesh_(std::move(mesh)), asked_(asked) {}

  Result<std::shared_ptr<const void>> charge(std::uint64_t bytes, Reclaim reclaim) const override {
    EXPECT_EQ(bytes, mesh_->bytes());
    if (asked_.charge_error) return *asked_.charge_error;
    ++asked_.charged;
    asked_.without_reclaim += reclaim == Reclaim::kForbidden ? 1 : 0;
    return std::shared_ptr<const void>(&asked_, [&asked = asked_](const void*) {
      --asked.charged;  // after the source is gone, too
    });
  }
  Result<std::shared_ptr<const Mesh>> read() const override {
    if (asked_.read_error) return *asked_.read_error;
    ++asked_.reads;
    if (asked_.while_read) asked_.while_read();
    return mesh_;
  }

 private:
  const std::shared_ptr<const Mesh> mesh_;
  Asked& asked_;
};

/// Two balls, 20 apart, each of a mesh of its own.
class UnreadMesh : public testing::Test {
 protected:
  UnreadMesh() {
    std::vector<Update> updates, updates_resident;
    for (int i = 0; i < 2; ++i) {
      resident_[i] = tests::mesh_of(tests::icosphere(4));
      PutNode put = tests::put_node(-1 - i, 0, resident_[i]);
      put.parent_from_local.m[3] = 20 * i;
      updates_resident.emplace_back(put);
      put.mesh = unread_[i] =
          resident_[i]->unread(std::make_unique<TestSource>(resident_[i], asked_[i]));
      updates.emplace_back(put);
    }
    EXPECT_TRUE(scene_.apply(updates));
    EXPECT_TRUE(scene_resident_.apply(updates_resident));
  }

  /// Downward, at both balls or past them.
  static std::vector<Ray> rays() {
    tests::Random random(7);
    std::vector<Ray> rays(3000);
    for (Ray& ray : rays) {
      ray.origin = {random.uniform(-2, 22), random.uniform(-1, 1), 5};
      ray.direction = {random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), -1};
    }
    return rays;
  }

  static Ray down(double x) {
    Ray ray;
    ray.origin = {x, 0.1, 5};
    ray.direction = {0, 0, -1};
    return ray;
  }

  Result<TraceStats> cast(const Ray& ray, const TraceOptions& options = {}) {
    return trace(*scene_.snapshot(), std::span(&ray, 1), std::span(&hit_, 1), options);
  }

  Asked asked_[2];
  std::shared_ptr<const Mesh> resident_[2], unread_[2];
  Scene scene_, scene_resident_;
  Hit hit_;
};

TEST_F(UnreadMesh, IsReadByTheFirstRayThatEntersIt) {
  ASSERT_TRUE(cast(down(10)));
  EXPECT_EQ(hit_.state, HitState::kMiss);
  EXPECT_FALSE(unread_[0]->is_resident() || unread_[1]->is_resident());
  ASSERT_TRUE(cast(down(0.1)));
  EXPECT_EQ(hit_.state, HitState::kHit);
  EXPECT_TRUE(unread_[0]->is_resident());
  EXPECT_FALSE(unread_[1]->is_resident());
  EXPECT_EQ(asked_[0].reads, 1);
  EXPECT_EQ(asked_[0].charged, 1);
}

TEST_F(UnreadMesh, SaysOfItselfWhatItDoesWhenItIsRead) {
  EXPECT_EQ(unread_[0]->bytes(), resident_[0]->bytes());
  EXPECT_EQ(unread_[0]->triangles(), resident_[0]->triangles());
  EXPECT_EQ(unread_[0]->faces(), resident_[0]->faces());
  EXPECT_EQ(unread_[0]->bounds().hi.x, resident_[0]->bounds().hi.x);
  EXPECT_EQ(unread_[0]->bytes_deformed(), resident_[0]->bytes_deformed());
  EXPECT_EQ(unread_[0]->tree_bytes(), 0u);
  EXPECT_EQ(unread_[0]->drop_tree(), 0u);
  const revision::BuildSummary now = revision::summarize_build(*scene_.snapshot());
  const revision::BuildSummary then = revision::summarize_build(*scene_resident_.snapshot());
  EXPECT_EQ(now.triangles_total, then.triangles_total);
  EXPECT_EQ(now.cells_deferred, then.cells_deferred);
  EXPECT_EQ(now.bytes_geometry, 0u);
  EXPECT_EQ(revision::deferred_cells(*scene_.snapshot(), 10).boxes,
            revision::deferred_cells(*scene_resident_.snapshot(), 10).boxes);
  EXPECT_EQ(asked_[0].reads, 0);
}

TEST_F(UnreadMesh, AnswersAsOneThatWasAlwaysThere) {
  for (const Growth growth : {Growth::kFirstTouch, Growth::kDemand, Growth::kFull, Growth::kNone}) {
    SCOPED_TRACE(static_cast<int>(growth));
    Scene fresh;
    Asked asked;
    PutNode put = tests::put_node(
        -1, 0, resident_[0]->unread(std::make_unique<TestSource>(resident_[0], asked)));
    ASSERT_TRUE(fresh.apply({Update(put)}));
    Scene known;
    put.mesh = resident_[0];
    ASSERT_TRUE(known.apply({Update(put)}));
    TraceOptions options;
    options.growth = growth;
    const auto expected = tests::ask_all_kinds(*known.snapshot(), rays(), options);
    const auto answers = tests::ask_all_kinds(*fresh.snapshot(), rays(), options);
    EXPECT_EQ(tests::contradiction(answers, options.max_hits), "");
    for (std::size_t i = 0; i < answers.closest.size(); ++i) {
      const Hit &now = answers.closest[i], &then = expected.closest[i];
      ASSERT_TRUE(now.state == then.state && now.primitive == then.primitive &&
                  (now.t == then.t || now.state != HitState::kHit))
          << i;
    }
    EXPECT_EQ(asked.reads, 1);
  }
}

TEST_F(UnreadMesh, IsReadOnceWhereManyRaysEnterItAtTheSameTime) {
  constexpr int kThreads = 8;
  const std::vector<Ray> many = rays();
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, kThreads);
  tbb::task_arena(kThreads).execute([&] {
    tbb::parallel_for(0, 4 * kThreads, [&](int) {
      std::vector<Hit> own(many.size());
      EXPECT_TRUE(trace(*scene_.snapshot(), many, own, {}));
    });
  });
  EXPECT_EQ(asked_[0].reads, 1);
  EXPECT_EQ(asked_[0].charged, 1);
  EXPECT_EQ(asked_[1].reads, 1);
}

TEST_F(UnreadMesh, AThreadThatReadsBeginsNoOtherTaskOfItsArena) {
  std::atomic<bool> reading{false}, begun_meanwhile{false};
  asked_[0].while_read = [&] {
    reading = true;
    // A part of the reading that another thread has, and takes long for.
    tbb::task_group part;
    tbb::task_arena other(1, 0);
    other.enqueue(part.defer([] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); }));
    part.wait();
    reading = false;
  };
  tbb::task_arena(1).execute([&] {
    tbb::task_group rays;
    rays.run([&] { begun_meanwhile = reading.load(); });
    EXPECT_TRUE(unread_[0]->make_resident(Reclaim::kAllowed));
    rays.wait();
  });
  EXPECT_FALSE(begun_meanwhile) << "it could need the mesh, and wait for itself";
}

TEST_F(UnreadMesh, PicturesOfWhatIsBuiltDoNotReadIt) {
  ASSERT_TRUE(cast(down(0.1), {.growth = Growth::kBuiltOnly}));
  EXPECT_EQ(hit_.state, HitState::kMiss);
  EXPECT_NE(hit_.work & accel::geometry::kWorkDeferred, 0u);
  EXPECT_EQ(asked_[0].reads, 0);
}

TEST_F(UnreadMesh, ThatCannotBeReadEndsTheBatchWithWhatItsSourceSays) {
  asked_[0].read_error = Error{Code::kUnavailable, "the disk is away", "STORE_IO"};
  const auto failed = cast(down(0.1));
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, Code::kUnavailable);
  EXPECT_EQ(failed.error().message, "the disk is away");
  EXPECT_EQ(asked_[0].charged, 0);
  const auto built = query::build_all(*scene_.snapshot());
  ASSERT_FALSE(built);
  EXPECT_EQ(built.error().reason, "STORE_IO");
  ASSERT_TRUE(cast(down(20.1)));  // the other one
  EXPECT_EQ(hit_.state, HitState::kHit);
  asked_[0].read_error.reset();
  ASSERT_TRUE(cast(down(0.1)));
  EXPECT_EQ(hit_.state, HitState::kHit);
}

TEST_F(UnreadMesh, ThatCannotBeReadLeavesWhatOthersBuildMeanwhileWhole) {
  constexpr int kThreads = 4;
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, kThreads);
  const tests::TestMesh ball = tests::icosphere(7);
  for (const Growth growth : {Growth::kFirstTouch, Growth::kDemand, Growth::kFull}) {
    SCOPED_TRACE(static_cast<int>(growth));
    Asked asked, asked_large;
    asked.read_error = Error{Code::kUnavailable, "the disk is away", "STORE_IO"};
    const auto large = tests::mesh_of(ball);
    PutNode lost = tests::put_node(
        -1, 0, resident_[0]->unread(std::make_unique<TestSource>(resident_[0], asked)));
    PutNode other =
        tests::put_node(-2, 0, large->unread(std::make_unique<TestSource>(large, asked_large)));
    other.parent_from_local.m[3] = 20;
    Scene scene, known;
    ASSERT_TRUE(scene.apply({Update(lost), Update(other)}));
    lost.mesh = resident_[0];
    other.mesh = tests::mesh_of(ball);
    ASSERT_TRUE(known.apply({Update(lost), Update(other)}));
    TraceOptions options;
    options.growth = growth;
    const std::vector<Ray> many = rays();
    std::vector<Hit> hits(many.size()), expected(many.size());
    tbb::task_arena(kThreads).execute([&] {
      EXPECT_EQ(trace(*scene.snapshot(), many, hits, options).error().reason, "STORE_IO");
    });
    asked.read_error.reset();
    ASSERT_TRUE(trace(*scene.snapshot(), many, hits, options));
    ASSERT_TRUE(trace(*known.snapshot(), many, expected, options));
    for (std::size_t i = 0; i < hits.size(); ++i)
      ASSERT_TRUE(hits[i].t == expected[i].t || hits[i].state == HitState::kMiss) << i;
    for (std::size_t i = 0; i < hits.size(); ++i) ASSERT_EQ(hits[i].state, expected[i].state) << i;
  }
}

TEST_F(UnreadMesh, WithoutMemoryIsNotRead) {
  asked_[0].charge_error = Error{Code::kResourceExhausted, "no memory", "MEMORY_BUDGET"};
  const auto failed = cast(down(0.1));
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().reason, "MEMORY_BUDGET");
  EXPECT_EQ(asked_[0].reads, 0);
}

TEST_F(UnreadMesh, IsReadForAPatchOfItsVerticesUnderTheLock) {
  PatchVertices patch;
  patch.nodes = {1};
  patch.positions = {{0, 0, 3}};
  ASSERT_TRUE(scene_.apply({Update(patch)}));
  EXPECT_EQ(asked_[0].reads, 1);
  EXPECT_EQ(asked_[0].without_reclaim, 1);
  EXPECT_EQ(asked_[1].reads, 0);
}

TEST_F(UnreadMesh, GivesItsChargeBackWhenItIsGone) {
  Asked asked;
  auto mesh = resident_[0]->unread(std::make_unique<TestSource>(resident_[0], asked));
  ASSERT_TRUE(mesh->make_resident(Reclaim::kAllowed));
  EXPECT_EQ(asked.charged, 1);
  mesh.reset();
  EXPECT_EQ(asked.charged, 0);
}

}  // namespace
}  // namespace sightline::scenegraph::model
