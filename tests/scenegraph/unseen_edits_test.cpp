// Updates of every kind before the first ray, when both trees may change: answers equal brute
// force.
#include <gtest/gtest.h>

#include "scenegraph/scene.h"
#include "tests/support/random_edits.h"
#include "tests/support/random_questions.h"

namespace sightline::tests {
namespace {

// Applies that many valid batches; the nodes beside the ground need a few.
PlainScene edit_unseen(scenegraph::Scene& scene, RandomEdit begin, RandomEdits& edits,
                       std::uint64_t batches) {
  EXPECT_TRUE(scene.apply(begin.updates));
  PlainScene plain = std::move(begin.after);
  for (std::uint64_t valid = 0; valid < batches;) {
    RandomEdit edit = edits.next(plain);
    const auto applied = scene.apply(edit.updates);
    EXPECT_EQ(applied.ok(), !edit.refusal);
    if (!applied) continue;
    plain = std::move(edit.after);
    ++valid;
  }
  return plain;
}

bool is_static(const PlainScene& plain, scenegraph::model::NodeId id) {
  for (; id != 0; id = plain.nodes().at(id).parent) {
    if (plain.nodes().at(id).mobility != scenegraph::model::Mobility::kStatic) return false;
  }
  return true;
}

// Nothing but static nodes, with what is below them.
void move_static_nodes(scenegraph::Scene& scene, PlainScene& plain) {
  scenegraph::model::SetTransforms set;
  for (const auto& [id, node] : plain.nodes()) {
    if (id <= kGround + 1 || !is_static(plain, id)) continue;
    set.nodes.push_back(plain.refer(id));
    set.parent_from_local.push_back(node.parent_from_local);
    set.parent_from_local.back().m[3] += 4;
  }
  if (set.nodes.empty()) return;
  ASSERT_TRUE(scene.apply({set}));
  plain.apply(set);
  plain.publish();
}

TEST(UnseenEdits, FirstRaysEqualBruteForce) {
  const std::vector<MeshChoice> meshes = small_meshes();
  std::uint64_t hits = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    scenegraph::Scene scene;
    RandomEdits edits(meshes, seed);
    PlainScene plain = edit_unseen(scene, ground(meshes), edits, 4 + seed % 8);
    if (seed % 2 == 0) move_static_nodes(scene, plain);
    Random random(seed + 1000);
    const RandomQuestion question = random_question(plain, 24, random);
    if (question.rays.empty() || question.root != 0 || !question.excluded.empty()) continue;
    scenegraph::TraceOptions options;
    options.culling = question.culling;
    options.max_hits = question.max_hits;
    const KindAnswers answers = ask_all_kinds(*scene.snapshot(), question.rays, options);
    const KindComparison compared = judge(plain, question, answers);
    ASSERT_EQ(compared.mismatches, 0u) << compared.report();
    hits += compared.hits;
  }
  EXPECT_GT(hits, 500u);
}

}  // namespace
}  // namespace sightline::tests
