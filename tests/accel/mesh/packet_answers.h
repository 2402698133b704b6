// Packets in the tree of a mesh, and what the hit rule says of their rays without a tree.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/mesh/face_test.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/wide/packet.h"
#include "tests/accel/wide/mesh_as_tree.h"
#include "tests/accel/wide/rule_over_mesh.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// Rays, and all that they hit by the rule.
struct RaysByRule {
  RaysByRule(const TestMesh& mesh, std::vector<accel::geometry::Ray> of) : rays(std::move(of)) {
    for (const accel::geometry::Ray& ray : rays) hits.push_back(line_hits(mesh, ray));
  }

  Answer expected(std::size_t ray, const Question& question) const {
    return answer(hits[ray], rays[ray], question);
  }

  std::vector<accel::geometry::Ray> rays;
  std::vector<std::vector<LineHit>> hits;
};

/// The rays of one packet, asked once or more often. Not pinned.
class AskedPacket {
 public:
  AskedPacket(std::span<const accel::geometry::Ray> rays, const Question& question)
      : rays_(rays.size()), lanes_((2u << (rays.size() - 1)) - 1) {
    best->clear();
    packet->best = best.get();
    packet->goal = question.any ? accel::wide::Goal::kAny : accel::wide::Goal::kNearest;
    packet->culling = question.culling;
    packet->node = 1;
    packet->work.fill(0);
    set_rays(rays, packet->rays);
  }

  std::uint32_t lanes() const { return lanes_; }

  void ask(accel::mesh::MeshTree& tree) {
    const accel::kdtree::EpochPin pin;
    tree.query(*packet, lanes_, cells, walked, built);
  }
  void ask(accel::lazy::LazyTree& tree, const accel::geometry::MeshView& mesh) {
    const accel::kdtree::EpochPin pin;
    accel::mesh::query_faces(tree, mesh, *packet, lanes_, cells, walked, built);
  }

  Answer answer(std::size_t lane) const {
    const bool found = (best->found >> lane & 1) != 0;
    if (!found || packet->goal == accel::wide::Goal::kAny) return {found};
    return {true, best->t[lane], best->primitive[lane]};
  }

  std::uint64_t work() const {
    std::uint64_t sum = 0;
    for (std::size_t lane = 0; lane < rays_; ++lane) sum += packet->work[lane];
    return sum;
  }

  std::unique_ptr<accel::wide::Packet> packet = std::make_unique<accel::wide::Packet>();
  std::unique_ptr<accel::wide::BestHits> best = std::make_unique<accel::wide::BestHits>();
  accel::lazy::CellQuery cells;
  accel::kdtree::WalkCounters walked;
  accel::kdtree::BuildCounters built;

 private:
  std::size_t rays_;
  std::uint32_t lanes_;
};

/// Calls test(rays) for the rays in packets of `size`.
template <class Test>
void each_packet(std::span<const accel::geometry::Ray> rays, std::size_t size, const Test& test) {
  for (std::size_t i = 0; i < rays.size(); i += size)
    test(rays.subspan(i, std::min(size, rays.size() - i)));
}

/// The tree's packets answer every question as the hit rule does. Returns how many rays hit
/// something.
inline std::size_t expect_exact(accel::lazy::LazyTree& tree, const TestMesh& mesh,
                                const RaysByRule& of) {
  std::size_t hits = 0;
  for (std::size_t i = 0; i < of.rays.size(); i += accel::wide::kLanes) {
    const auto part =
        std::span(of.rays).subspan(i, std::min(accel::wide::kLanes, of.rays.size() - i));
    for (const Question& question : kQuestions) {
      AskedPacket asked(part, question);
      asked.ask(tree, mesh.view());
      for (std::size_t lane = 0; lane < part.size(); ++lane) {
        const Answer expected = of.expected(i + lane, question);
        EXPECT_EQ(asked.answer(lane), expected);
        hits += expected.found ? 1 : 0;
      }
    }
  }
  return hits;
}
inline std::size_t expect_exact(accel::lazy::LazyTree& tree, const TestMesh& mesh,
                                std::span<const accel::geometry::Ray> rays) {
  return expect_exact(tree, mesh, RaysByRule(mesh, {rays.begin(), rays.end()}));
}

}  // namespace sightline::tests
