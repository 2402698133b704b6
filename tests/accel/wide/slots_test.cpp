// Walks of packets through wide nodes over slots: finished ones, ones that are finished on the way,
// and ones that never are.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <memory>
#include <vector>

#include "accel/wide/walk.h"
#include "tests/accel/simd_targets.h"
#include "tests/accel/wide/mesh_as_tree.h"
#include "tests/accel/wide/mesh_in_parts.h"
#include "tests/support/hard_rays.h"

namespace sightline::accel::wide {
namespace {

using geometry::Ray;
using tests::Answer;
using tests::MeshInParts;
using tests::search;
using tests::TestMesh;

class Slots : public tests::OnSimdTarget {};
INSTANTIATE_TEST_SUITE_P(Every, Slots, tests::every_simd_target(), tests::simd_target_name);

enum class AtSlot : std::uint8_t { kFinish, kSkip, kStop };

/// Notes which rays meet which slots.
class Visitor {
 public:
  Visitor(MeshInParts& parts, Packet& packet, AtSlot does)
      : met(parts.slots.size()),
        visits(parts.slots.size()),
        parts_(parts),
        packet_(packet),
        does_(does) {}

  Child enter(kdtree::AtomicSlot& slot, std::uint32_t lanes) {
    EXPECT_NE(lanes, 0u);
    EXPECT_FALSE(packet_.stopped);
    const std::size_t part = parts_.part_of(slot);
    met.at(part) |= lanes;
    ++visits.at(part);
    if (does_ == AtSlot::kFinish) parts_.finish(part);
    if (does_ == AtSlot::kStop) packet_.stopped = true;
    return does_ == AtSlot::kFinish ? Child::at(slot) : Child{};
  }
  static void visit(std::span<const std::uint32_t>, std::uint32_t) {}

  std::vector<std::uint32_t> met;
  std::vector<int> visits;

 private:
  MeshInParts& parts_;
  Packet& packet_;
  const AtSlot does_;
};

/// A packet that has walked.
struct Walk {
  Walk(const MeshInParts& parts, std::span<const Ray> rays, bool any) {
    best->clear();
    packet->best = best.get();
    packet->goal = any ? Goal::kAny : Goal::kNearest;
    packet->node = 1;
    packet->work.fill(0);
    tests::set_rays(rays, packet->rays);
    live = prepare(*packet, parts.of.frame, (2u << (rays.size() - 1)) - 1);
  }

  void run(Child root, Visitor& visitor) {
    kdtree::WalkCounters walked;
    walk(*packet, root, live, Leaf(visitor), walked);
    if (packet->goal == Goal::kNearest && !packet->stopped) resolve(*packet, live);
  }

  Answer answer(std::size_t lane) const {
    const bool found = (best->found >> lane & 1) != 0;
    if (!found || packet->goal == Goal::kAny) return {found};
    return {true, best->t[lane], best->primitive[lane]};
  }

  std::unique_ptr<Packet> packet = std::make_unique<Packet>();
  std::unique_ptr<BestHits> best = std::make_unique<BestHits>();
  std::uint32_t live = 0;
};

/// Calls test(parts, rays, any) for trees of 2 to 40 parts, and packets of all kinds of sizes.
template <class Test>
void each_packet(const Test& test) {
  const TestMesh mesh = tests::random_soup(400, 0.2, 3);
  const std::vector<Ray> hard = tests::make_hard_rays(mesh, 96, 4);
  std::vector<Ray> rays = tests::rays_at(mesh, 32, 5);
  // The rays of a camera walk as groups.
  for (std::size_t i = 0; i < 32; ++i) {
    const double x = static_cast<double>(i) / 32;
    rays.push_back({{0.5, 0.5, -2}, {x - 0.5, 0.3 * x, 2}});
  }
  rays.insert(rays.end(), hard.begin(), hard.end());
  for (const std::size_t count : {2u, 8u, 9u, 40u}) {
    for (const std::size_t size : {1u, 3u, 5u, 16u}) {
      MeshInParts parts(mesh, count);
      for (std::size_t i = 0; i < rays.size(); i += size) {
        const auto packet = std::span<const Ray>(rays).subspan(i, std::min(size, rays.size() - i));
        for (const bool any : {false, true}) {
          test(parts, packet, any);
          if (::testing::Test::HasFatalFailure()) return;
        }
      }
    }
  }
}

TEST_P(Slots, FinishedOnesAreWalkedThrough) {
  std::size_t hits = 0;
  each_packet([&](MeshInParts& parts, std::span<const Ray> rays, bool any) {
    for (std::size_t part = 0; part < parts.slots.size(); ++part) parts.finish(part);
    Walk walk(parts, rays, any);
    Visitor visitor(parts, *walk.packet, AtSlot::kSkip);
    walk.run(parts.root(), visitor);
    for (const int visits : visitor.visits) ASSERT_EQ(visits, 0);
    for (std::size_t lane = 0; lane < rays.size(); ++lane) {
      const Answer expected = search(parts, rays[lane], any, [](std::size_t) { return true; });
      ASSERT_EQ(walk.answer(lane), expected);
      hits += expected.found ? 1 : 0;
    }
  });
  EXPECT_GT(hits, 100u);
}

TEST_P(Slots, OnesThatARayFinishesAreWalkedThrough) {
  each_packet([&](MeshInParts& parts, std::span<const Ray> rays, bool any) {
    for (std::size_t part = 0; part < parts.slots.size(); ++part) parts.open(part);
    Walk walk(parts, rays, any);
    Visitor visitor(parts, *walk.packet, AtSlot::kFinish);
    walk.run(parts.root(), visitor);
    for (std::size_t part = 0; part < parts.slots.size(); ++part) {
      ASSERT_LE(visitor.visits[part], 1);
      ASSERT_EQ(visitor.met[part] & ~walk.live, 0u);
    }
    for (std::size_t lane = 0; lane < rays.size(); ++lane) {
      ASSERT_EQ(walk.answer(lane),
                search(parts, rays[lane], any, [](std::size_t) { return true; }));
    }
  });
}

// Every other part is finished. A ray that does not meet a slot has no better hit there.
TEST_P(Slots, EveryRayWithAHitBelowASlotMeetsIt) {
  each_packet([&](MeshInParts& parts, std::span<const Ray> rays, bool any) {
    for (std::size_t part = 0; part < parts.slots.size(); ++part) {
      parts.open(part);
      if (part % 2 == 0) parts.finish(part);
    }
    Walk walk(parts, rays, any);
    Visitor visitor(parts, *walk.packet, AtSlot::kSkip);
    walk.run(parts.root(), visitor);
    for (std::size_t lane = 0; lane < rays.size(); ++lane) {
      const auto is_finished = [](std::size_t part) { return part % 2 == 0; };
      ASSERT_EQ(walk.answer(lane), search(parts, rays[lane], any, is_finished));
      const auto may_count = [&](std::size_t part) {
        return part % 2 == 0 || (visitor.met[part] >> lane & 1) == 0;
      };
      ASSERT_EQ(walk.answer(lane), search(parts, rays[lane], any, may_count));
    }
  });
}

TEST_P(Slots, AStoppedPacketGoesNoFurther) {
  each_packet([&](MeshInParts& parts, std::span<const Ray> rays, bool any) {
    for (std::size_t part = 0; part < parts.slots.size(); ++part) parts.open(part);
    Walk walk(parts, rays, any);
    Visitor visitor(parts, *walk.packet, AtSlot::kStop);
    walk.run(parts.root(), visitor);
    int visits = 0;
    for (const int of_part : visitor.visits) visits += of_part;
    ASSERT_EQ(visits, walk.packet->stopped ? 1 : 0);
  });
}

TEST_P(Slots, ARootMayBeASlot) {
  each_packet([&](MeshInParts& parts, std::span<const Ray> rays, bool any) {
    parts.open(0);
    const auto is_first = [](std::size_t part) { return part == 0; };
    Walk walk(parts, rays, any);
    Visitor visitor(parts, *walk.packet, AtSlot::kFinish);
    walk.run(Child::at(*parts.slots[0]), visitor);
    ASSERT_EQ(visitor.met[0], walk.live);
    for (std::size_t lane = 0; lane < rays.size(); ++lane)
      ASSERT_EQ(walk.answer(lane), search(parts, rays[lane], any, is_first));
  });
}

}  // namespace
}  // namespace sightline::accel::wide
