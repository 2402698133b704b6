// Updates and casts of every kind in random order, from several threads: every answer equals brute
// force at the revision it names. A held revision does not change.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <deque>
#include <iterator>
#include <memory>
#include <thread>
#include <vector>

#include "scenegraph/query/selection.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/support/plain_history.h"
#include "tests/support/random_edits.h"
#include "tests/support/random_questions.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

using scenegraph::Growth;
using scenegraph::Scene;
using scenegraph::revision::Snapshot;

constexpr std::size_t kRays = 24;
constexpr int kThreads = 4;

// A scene, its plain copy at each revision, and the progress of the stress.
struct Stress {
  explicit Stress(std::uint64_t updates) : wanted(updates) {}

  // Few nodes make several trees, which are merged.
  Scene scene{{.small_tree = 4, .at_once = 16}};
  PlainHistory history;
  const std::vector<MeshChoice> meshes = small_meshes();
  const std::uint64_t wanted;
  std::atomic<std::uint64_t> applied{0}, refused{0}, rebuilt{0}, outrun{0}, casts{0}, hits{0},
      edges{0};

  bool done() const { return applied >= wanted || testing::Test::HasFailure(); }
};

// One thread: updates the scene and casts at it, at random.
class Actor {
 public:
  Actor(Stress& stress, std::uint64_t seed)
      : stress_(stress), random_(seed), edits_(stress.meshes, seed + 1000) {}

  void run() {
    while (!stress_.done()) {
      if (random_.below(3) == 0) {
        update();
      } else {
        cast();
      }
    }
  }

 private:
  void update() {
    const auto now = stress_.history.latest();
    RandomEdit edit = edits_.next(*now);
    const auto applied = stress_.scene.apply(edit.updates, {.expected_revision = now->revision()});
    if (!applied && applied.error().code == Code::kAborted) {
      ++stress_.outrun;
      return;
    }
    ASSERT_EQ(applied.ok(), !edit.refusal) << (applied ? "accepted" : applied.error().message);
    if (!applied) {
      ASSERT_EQ(applied.error().code, *edit.refusal) << applied.error().message;
      ++stress_.refused;
      return;
    }
    ASSERT_EQ(applied->revision, edit.after.revision());
    ASSERT_EQ(applied->nodes, edit.put_nodes);
    stress_.history.add(std::move(edit.after));
    ++stress_.applied;
    if (applied->merge_trees || random_.below(50) == 0) {
      stress_.scene.merge_trees();
      ++stress_.rebuilt;
    }
  }

  // A revision of the scene, and its plain copy.
  struct Revision {
    std::shared_ptr<const Snapshot> snapshot;
    std::shared_ptr<const PlainScene> plain;
  };

  // The newest revision, or one that this thread has held for a while.
  Revision some_revision() {
    if (held_.empty() || random_.below(3) != 0) {
      const std::shared_ptr<const Snapshot> newest = stress_.scene.snapshot();
      held_.push_back({newest, stress_.history.at(newest->revision())});
      if (held_.size() > 4) held_.pop_front();
      return held_.back();
    }
    return held_[random_.below(held_.size())];
  }

  void cast() {
    const auto [snapshot, plain] = some_revision();
    ASSERT_NE(plain, nullptr) << "revision " << snapshot->revision() << " is not kept";
    const RandomQuestion question = random_question(*plain, kRays, random_);
    if (question.rays.empty()) return;
    scenegraph::TraceOptions options;
    options.culling = question.culling;
    options.max_hits = question.max_hits;
    constexpr Growth kGrowths[] = {Growth::kFirstTouch, Growth::kFirstTouch, Growth::kFirstTouch,
                                   Growth::kNone, Growth::kFull};
    options.growth = kGrowths[random_.below(std::size(kGrowths))];
    std::unique_ptr<scenegraph::query::Selection> selection;
    if (question.root != 0 || !question.excluded.empty()) {
      auto made = scenegraph::query::Selection::make(snapshot, question.root, question.excluded);
      ASSERT_TRUE(made) << made.error().message;
      selection = std::make_unique<scenegraph::query::Selection>(std::move(*made));
      options.selection = selection.get();
    }
    const KindAnswers answers = ask_all_kinds(*snapshot, question.rays, options);
    ASSERT_EQ(contradiction(answers, question.max_hits), "") << "revision " << plain->revision();
    const KindComparison compared = judge(*plain, question, answers);
    ASSERT_EQ(compared.mismatches, 0u)
        << "revision " << plain->revision() << ": " << compared.report();
    ++stress_.casts;
    stress_.hits += compared.hits;
    stress_.edges += compared.edges;
  }

  Stress& stress_;
  Random random_;
  RandomEdits edits_;
  std::deque<Revision> held_;
};

TEST(MovingStress, EveryAnswerEqualsBruteForceAtItsRevision) {
  Stress stress(stress_updates(200));
  RandomEdit begin = ground(stress.meshes);
  ASSERT_TRUE(stress.scene.apply(begin.updates));
  stress.history.add(std::move(begin.after));
  std::vector<std::jthread> threads;
  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([&stress, i] { Actor(stress, static_cast<std::uint64_t>(i)).run(); });
  }
  threads.clear();
  EXPECT_GE(stress.applied, stress.wanted);
  EXPECT_GT(stress.refused, stress.wanted / 20);
  EXPECT_GT(stress.casts, stress.wanted / 2);
  EXPECT_GT(stress.hits, stress.casts * kRays / 4);
  EXPECT_LT(stress.edges, stress.hits / 100);
  for (const auto& [name, count] : {std::pair{"casts", &stress.casts},
                                    {"refused", &stress.refused},
                                    {"outrun", &stress.outrun},
                                    {"rebuilt", &stress.rebuilt},
                                    {"hits", &stress.hits}})
    RecordProperty(name, std::to_string(*count));
}

// Twenty balls in a row; the odd ones are declared rigid.
std::vector<scenegraph::model::Update> row_of_balls(
    const std::shared_ptr<const scenegraph::model::Mesh>& ball) {
  std::vector<scenegraph::model::Update> updates;
  for (int i = 0; i < 20; ++i) {
    scenegraph::model::PutNode put;
    put.node = -1 - i;
    put.parent_from_local.m[3] = 3 * i;
    put.mesh = ball;
    if (i % 2 == 1) put.mobility = scenegraph::model::Mobility::kRigid;
    updates.emplace_back(put);
  }
  return updates;
}

std::vector<scenegraph::model::Update> step(std::uint64_t revision) {
  scenegraph::model::SetTransforms set;
  for (int i = 0; i < 20; ++i) {
    scenegraph::model::Affine transform;
    transform.m[3] = 3 * i;
    transform.m[7] =
        0.01 * static_cast<double>((revision * 7 + static_cast<std::uint64_t>(i)) % 100);
    set.nodes.push_back(i + 1);
    set.parent_from_local.push_back(transform);
  }
  return {set};
}

std::vector<accel::geometry::Ray> rays_along(std::size_t count) {
  Random random(11);
  std::vector<accel::geometry::Ray> rays(count);
  for (accel::geometry::Ray& ray : rays) {
    ray.origin = {random.uniform(-2, 60), random.uniform(-2, 2), 30};
    ray.direction = {random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), -1};
  }
  return rays;
}

// Seconds for which the writer runs; SIGHTLINE_HOLD_SECONDS=10 is the full size.
double hold_seconds() {
  const char* text = std::getenv("SIGHTLINE_HOLD_SECONDS");
  return text != nullptr ? std::strtod(text, nullptr) : 0;
}

TEST(HeldSnapshot, DoesNotChangeWhileAWriterContinuesAndOthersAreFreed) {
  const TestMesh sphere = icosphere(4);
  Scene scene;
  ASSERT_TRUE(
      scene.apply(row_of_balls(*scenegraph::model::Mesh::make(sphere.vertices, sphere.faces))));
  std::shared_ptr<const Snapshot> held = scene.snapshot();
  const std::vector<accel::geometry::Ray> rays = rays_along(4000);
  const auto answers = [&](const Snapshot& snapshot) {
    std::vector<accel::geometry::Hit> hits(rays.size());
    EXPECT_TRUE(scenegraph::trace(snapshot, rays, hits, {}));
    return hits;
  };
  const std::vector<accel::geometry::Hit> first = answers(*held);
  const auto same = [&](const std::vector<accel::geometry::Hit>& again) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (first[i].t != again[i].t || first[i].node != again[i].node ||
          first[i].primitive != again[i].primitive)
        return false;
    }
    return true;
  };

  std::atomic<bool> over{false};
  std::atomic<std::uint64_t> casts{0};
  std::thread reader([&] {
    do {
      EXPECT_TRUE(same(answers(*held))) << "a held revision has changed";
      ++casts;
    } while (!over);
  });
  std::vector<std::weak_ptr<const Snapshot>> superseded;
  const auto begin = std::chrono::steady_clock::now();
  const auto until = begin + std::chrono::duration<double>(hold_seconds());
  for (std::uint64_t n = 0; n < 400 || std::chrono::steady_clock::now() < until; ++n) {
    const auto applied = scene.apply(step(n));
    ASSERT_TRUE(applied) << applied.error().message;
    if (applied->merge_trees) scene.merge_trees();
    if (n % 10 == 0) answers(*scene.snapshot());
    superseded.push_back(scene.snapshot());
  }
  over = true;
  reader.join();
  EXPECT_GT(casts, 0u);

  superseded.pop_back();  // The newest revision stays alive
  const auto alive = [&] {
    return std::count_if(superseded.begin(), superseded.end(),
                         [](const auto& snapshot) { return !snapshot.expired(); });
  };
  EXPECT_EQ(alive(), 0);
  EXPECT_TRUE(same(answers(*held)));
  const std::weak_ptr<const Snapshot> last_reader = held;
  held.reset();
  EXPECT_TRUE(last_reader.expired());
}

}  // namespace
}  // namespace sightline::tests
