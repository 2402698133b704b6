// Packets in the tree of a mesh, and what the hit rule says of their rays without a tree.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <ostream>
#include <span>
#include <vector>

#include "accel/geometry/intersect.h"
#include "accel/kdtree/epoch.h"
#include "accel/mesh/face_test.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/wide/packet.h"
#include "tests/accel/wide/mesh_as_tree.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

struct PacketQuestion {
  bool any = false;
  accel::geometry::Culling culling = accel::geometry::Culling::kNone;
};

inline constexpr PacketQuestion kPacketQuestions[] = {
    {},
    {.any = true},
    {.culling = accel::geometry::Culling::kBack},
    {.any = true, .culling = accel::geometry::Culling::kFront}};

/// For any hit, only whether there is one.
struct PacketAnswer {
  bool found = false;
  double t = 0;
  std::uint32_t primitive = 0;
  bool operator==(const PacketAnswer&) const = default;
};

inline std::ostream& operator<<(std::ostream& out, const PacketAnswer& answer) {
  if (!answer.found) return out << "nothing";
  return out << "t " << answer.t << ", triangle " << answer.primitive;
}

inline PacketAnswer search(const TestMesh& mesh, const accel::geometry::Ray& ray,
                           const PacketQuestion& question) {
  const auto local = *accel::geometry::make_local_ray(ray.origin, ray.direction);
  PacketAnswer best;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const accel::geometry::Face& f = mesh.faces[i];
    const accel::geometry::Vec3f &a = mesh.vertices[f[0]], &b = mesh.vertices[f[1]],
                                 &c = mesh.vertices[f[2]];
    const std::optional<double> t = intersect(local, a, b, c);
    if (!t || is_culled(question.culling, local, a, b, c)) continue;
    const double world = *t * local.unit;
    if (!(world >= ray.tmin && world <= ray.tmax) || (best.found && world >= best.t)) continue;
    if (question.any) return {true};
    best = {true, world, static_cast<std::uint32_t>(i)};
  }
  return best;
}

/// The rays of one packet, asked once or more often. Not pinned.
class AskedPacket {
 public:
  AskedPacket(std::span<const accel::geometry::Ray> rays, const PacketQuestion& question)
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

  PacketAnswer answer(std::size_t lane) const {
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
                                std::span<const accel::geometry::Ray> rays) {
  std::size_t hits = 0;
  each_packet(rays, accel::wide::kLanes, [&](std::span<const accel::geometry::Ray> part) {
    for (const PacketQuestion& question : kPacketQuestions) {
      AskedPacket asked(part, question);
      asked.ask(tree, mesh.view());
      for (std::size_t lane = 0; lane < part.size(); ++lane) {
        const PacketAnswer expected = search(mesh, part[lane], question);
        EXPECT_EQ(asked.answer(lane), expected);
        hits += expected.found ? 1 : 0;
      }
    }
  });
  return hits;
}

}  // namespace sightline::tests
