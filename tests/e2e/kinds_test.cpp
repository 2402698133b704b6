// Closest, any, count and all over the wire: they agree with each other and with brute force on
// every ray, with masks, culling, roots, exclusions and limits.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "tests/bench/scenes/load_scene.h"
#include "tests/e2e/served_scene.h"
#include "tests/support/brute_force.h"
#include "tests/support/kinds.h"
#include "tests/support/random.h"

namespace sightline::tests {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;

constexpr std::uint32_t kMaxHits = 1000;

// One million rays in all, each traced with every kind.
constexpr SceneFile kKindsScenes[] = {
    {"bunny", "bunny.ply", 125'000},
    {"sponza", "sponza.glb", 125'000},
    {"sibenik", "sibenik.ply", 125'000},
    {"wine", "wine.dae", 125'000},
    {"reciprocating_saw", "reciprocating_saw.glb", 125'000},
    {"torcs_forza", "torcs_forza.glb", 125'000},
    {"fzk_haus", "fzk_haus.ifc", 125'000},
    {"sterngarten", "sterngarten.obj", 125'000},
};

// The options besides the kind.
struct Question {
  client::Culling culling = client::Culling::kNone;
  std::uint64_t root = 0;
  std::vector<std::uint64_t> exclude;

  client::CastOptions options(client::QueryKind kind) const {
    client::CastOptions options;
    options.kind = kind;
    options.culling = culling;
    options.root = root;
    options.exclude = exclude;
    if (kind == client::QueryKind::kAll) options.max_hits = kMaxHits;
    return options;
  }
};

// Nodes that the query hides, from the parents in the file.
std::vector<std::uint64_t> hidden_nodes(const bench::SceneSource& scene, const Question& question) {
  std::vector<std::uint64_t> hidden;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    bool under = question.root == 0, out = false;
    for (std::optional<std::size_t> at = i; at; at = scene.nodes[*at].parent) {
      under = under || *at + 1 == question.root;
      out = out || std::count(question.exclude.begin(), question.exclude.end(), *at + 1) > 0;
    }
    if (out || !under) hidden.push_back(i + 1);
  }
  return hidden;
}

// The first query sees everything; the others exclude something, but never all meshes.
std::vector<Question> questions(const bench::SceneSource& scene) {
  Random random(5);
  std::vector<std::uint64_t> with_mesh;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (scene.nodes[i].mesh) with_mesh.push_back(i + 1);
  }
  const auto any_node = [&] { return with_mesh[random.below(with_mesh.size())]; };
  const auto some = [&](std::size_t most) {
    std::vector<std::uint64_t> nodes;
    for (std::size_t i = 0; i < std::min(most, with_mesh.size() / 3); ++i)
      nodes.push_back(any_node());
    return nodes;
  };
  const std::uint64_t node = any_node();
  const auto parent = scene.nodes[node - 1].parent;
  std::vector<Question> all(1);
  all.push_back({client::Culling::kBack, 0, some(2)});
  all.push_back({client::Culling::kFront, parent ? *parent + 1 : node, {}});
  all.push_back({client::Culling::kNone, 0, some(50)});
  return all;
}

double diagonal_of(const std::vector<PlacedMesh>& placed) {
  scenegraph::revision::WorldBounds bounds;
  for (const PlacedMesh& mesh : placed) {
    for (const accel::geometry::Vec3f& v : mesh.mesh.vertices) {
      if (is_finite(v)) bounds.grow(mesh.world_from_local.point(accel::geometry::Vec3d(v)));
    }
  }
  return length(bounds.hi - bounds.lo);
}

// Half of them have limits around the scene, and three quarters have a mask.
void vary(double diagonal, std::vector<Ray>& rays) {
  Random random(6);
  for (Ray& ray : rays) {
    if (random.below(2) == 0) {
      const double reach = diagonal / length(ray.direction);
      ray.tmin = random.uniform(-0.2, 1.2) * reach;
      ray.tmax = ray.tmin + random.uniform(0, 1.5) * reach;
    }
    ray.mask = static_cast<std::uint32_t>(random.below(8));
    if (random.below(4) == 0) ray.mask = accel::geometry::kAllMasks;
  }
}

constexpr std::uint32_t mask_of(std::uint64_t node) { return 1u << (node % 3); }

struct RayArrays {
  std::vector<double> origins, directions, tmin, tmax;
  std::vector<std::uint32_t> masks;

  explicit RayArrays(std::span<const Ray> rays) {
    for (const Ray& ray : rays) {
      origins.insert(origins.end(), {ray.origin.x, ray.origin.y, ray.origin.z});
      directions.insert(directions.end(), {ray.direction.x, ray.direction.y, ray.direction.z});
      tmin.push_back(ray.tmin);
      tmax.push_back(ray.tmax);
      masks.push_back(ray.mask);
    }
  }
  client::RayColumns<const double> columns() const {
    return {origins, directions, tmin, tmax, masks};
  }
};

HitState state_of(std::uint8_t hit) {
  return static_cast<HitState>(hit == client::kCutOff ? 1 : hit);
}

Hit make_hit(const client::AllHits& rows, std::size_t k) {
  Hit hit;
  hit.t = rows.t[k];
  hit.node = rows.node[k];
  hit.primitive = rows.primitive[k];
  hit.u = rows.barycentric[2 * k];
  hit.v = rows.barycentric[2 * k + 1];
  hit.normal = {rows.normal[3 * k], rows.normal[3 * k + 1], rows.normal[3 * k + 2]};
  hit.state = HitState::kHit;
  return hit;
}

class KindsTest : public ServedScene, public testing::WithParamInterface<SceneFile> {
 protected:
  /// Gives every node the mask of its number.
  void set_masks(std::size_t nodes) {
    std::vector<std::uint64_t> ids;
    for (std::uint64_t id = 1; id <= nodes; ++id) ids.push_back(id);
    const auto infos = client_->get_nodes(kScene, ids);
    ASSERT_TRUE(infos) << infos.error().message;
    std::vector<client::Update> updates;
    for (const client::NodeInfo& info : *infos) {
      updates.push_back(client::PutNode{
          static_cast<client::NodeRef>(info.id), static_cast<client::NodeRef>(info.parent),
          info.name, info.parent_from_local, info.mesh_digest, info.mobility, mask_of(info.id)});
    }
    const auto applied = client_->apply_in_batches(kScene, updates);
    ASSERT_TRUE(applied) << applied.error().message;
  }

  KindAnswers ask(std::span<const Ray> rays, const Question& question) {
    const RayArrays arrays(rays);
    KindAnswers answers;
    ask_closest(arrays, question, answers);
    std::vector<std::uint8_t> hit(rays.size());
    expect_ok(client_->cast_stream(kScene, arrays.columns(), {.hit = hit},
                                   question.options(client::QueryKind::kAny)));
    answers.any.resize(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) answers.any[i].state = state_of(hit[i]);
    std::vector<std::uint32_t> count(rays.size());
    expect_ok(client_->cast_stream(kScene, arrays.columns(), {.hit = hit, .count = count},
                                   question.options(client::QueryKind::kCount)));
    for (std::size_t i = 0; i < rays.size(); ++i)
      answers.counts.push_back({.count = count[i], .state = state_of(hit[i])});
    ask_all(arrays, question, answers);
    return answers;
  }

 private:
  static void expect_ok(const client::Result<client::CastReport>& report) {
    EXPECT_TRUE(report) << report.error().message;
  }

  void ask_closest(const RayArrays& arrays, const Question& question, KindAnswers& answers) {
    const std::size_t n = arrays.tmin.size();
    client::AllHits rows;
    rows.t.resize(n);
    rows.node.resize(n);
    rows.primitive.resize(n);
    rows.barycentric.resize(2 * n);
    rows.normal.resize(3 * n);
    rows.hit.resize(n);
    expect_ok(client_->cast_stream(kScene, arrays.columns(),
                                   {.t = rows.t,
                                    .node = rows.node,
                                    .primitive = rows.primitive,
                                    .barycentric = rows.barycentric,
                                    .normal = rows.normal,
                                    .hit = rows.hit},
                                   question.options(client::QueryKind::kClosest)));
    for (std::size_t i = 0; i < n; ++i) {
      answers.closest.push_back(make_hit(rows, i));
      answers.closest.back().state = state_of(rows.hit[i]);
    }
  }

  void ask_all(const RayArrays& arrays, const Question& question, KindAnswers& answers) {
    const auto all = client_->cast_all(
        kScene, arrays.columns(),
        {.t = true, .node = true, .primitive = true, .barycentric = true, .normal = true},
        question.options(client::QueryKind::kAll));
    ASSERT_TRUE(all) << all.error().message;
    for (std::size_t i = 0; i + 1 < all->offsets.size(); ++i) {
      answers.lists.push_back(
          {.count = static_cast<std::uint32_t>(all->offsets[i + 1] - all->offsets[i]),
           .state = state_of(all->hit[i]),
           .cut_off = all->hit[i] == client::kCutOff});
    }
    for (std::size_t k = 0; k < all->t.size(); ++k) answers.listed.push_back(make_hit(*all, k));
  }
};

TEST_P(KindsTest, AgreeWithEachOtherAndWithBruteForce) {
  ASSERT_NO_FATAL_FAILURE(serve(GetParam().file));
  if (IsSkipped()) return;
  const auto scene = bench::load_scene(file_.string());
  ASSERT_TRUE(scene.ok()) << scene.error().message;
  ASSERT_NO_FATAL_FAILURE(set_masks(scene->nodes.size()));
  std::vector<PlacedMesh> placed = placed_meshes(*scene);
  for (PlacedMesh& mesh : placed) mesh.mask = mask_of(mesh.node);
  const double diagonal = diagonal_of(placed);
  const BruteForce oracle(std::move(placed));

  std::vector<Ray> rays = mixed_rays(*scene, GetParam().rays / divisor());
  Random random(7);  // So that every query gets both kinds of ray
  for (std::size_t i = rays.size(); i > 1; --i) std::swap(rays[i - 1], rays[random.below(i)]);
  vary(diagonal, rays);
  const std::vector<Question> asked = questions(*scene);
  const std::size_t each = rays.size() / asked.size();
  std::uint64_t hits = 0;
  for (std::size_t q = 0; q < asked.size(); ++q) {
    const auto mine = std::span<const Ray>(rays).subspan(q * each, each);
    const KindAnswers answers = ask(mine, asked[q]);
    EXPECT_EQ(contradiction(answers, kMaxHits), "") << "question " << q;
    const auto culling = static_cast<accel::geometry::Culling>(asked[q].culling);
    const KindComparison compared =
        compare_kinds(mine, answers, oracle, {culling, hidden_nodes(*scene, asked[q])});
    EXPECT_EQ(compared.mismatches, 0u) << compared.report();
    EXPECT_EQ(compared.edges, 0u) << compared.report();
    hits += compared.hits;
  }
  EXPECT_GT(hits, rays.size() / 20);
  RecordProperty("hits", std::to_string(hits));
}

INSTANTIATE_TEST_SUITE_P(Scenes, KindsTest, testing::ValuesIn(kKindsScenes),
                         [](const auto& scene) { return std::string(scene.param.name); });

}  // namespace
}  // namespace sightline::tests
