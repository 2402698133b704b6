// The ray is one lane of a packet. Wide nodes and blocks are visited in floats, slots that are not
// finished as by any other ray.
#include "accel/mesh/walk_in_floats.h"

#include <bit>
#include <utility>

#include "accel/wide/float_rays.h"
#include "accel/wide/packet.h"
#include "accel/wide/walk.h"

namespace sightline::accel::mesh {
namespace {

class FloatWalk final : public wide::SlotVisitor, public wide::TriangleVisitor {
 public:
  FloatWalk(lazy::LazyTree& tree, LeafTest& test, kdtree::BuildCounters& built)
      : tree_(tree), test_(test), query_(test.query), visit_{tree, query_, built, *this} {
    set_ray();
  }

  bool run() {
    const wide::Prepared prepared = wide::prepare(packet_, *tree_.frame(), kLane);
    if (prepared.slow != 0) return false;
    if (prepared.live == 0) return true;
    // A thread that has renewed its pin may not go on in nodes that are replaced meanwhile.
    const wide::Child entry = tree_.entry();
    const bool searched_before =
        std::exchange(query_.searches_list, query_.searches_list || entry.is_node());
    walk_below(entry);
    query_.searches_list = searched_before;
    test_.walked.steps += totals_.nodes;
    test_.walked.tests += totals_.triangles;
    return true;
  }

  bool visit(kdtree::AtomicSlot& slot, std::uint32_t) override {
    const std::uint64_t before = test_.walked.steps;
    kdtree::walk(tree_.tree(), test_.ray, slot, test_.walked, visit_);
    tree_.count_steps(test_.walked.steps - before);
    packet_.stopped = query_.is_done();
    return false;
  }

  void visit(const blocks::Block& block, std::uint32_t triangles) override {
    for (; triangles != 0; triangles &= triangles - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(triangles));
      const auto corner = [&](std::size_t k) { return mesh_vertex(block, block.corner(k)[i]); };
      if (test_.decide(block.id(i), corner(0), corner(1), corner(2))) {
        packet_.stopped = true;
        return;
      }
    }
    tighten();
  }

  // For kdtree::walk.
  double limit() const { return test_.limit(); }
  bool leaf(std::span<const std::uint32_t> ids) { return tightened(test_.leaf(ids)); }
  bool reference(const kdtree::Reference& ref) { return tightened(test_.reference(ref)); }
  bool everything() { return tightened(test_.everything()); }
  bool finished(const kdtree::FinishedSubtree& subtree) {
    walk_below(static_cast<const wide::WideTree&>(subtree).root());
    return packet_.stopped;
  }

 private:
  static constexpr std::uint32_t kLane = 1;

  /// All lanes are this ray.
  void set_ray() {
    wide::Rays& rays = packet_.rays;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      rays.origin[axis].fill(query_.ray.origin[axis]);
      rays.direction[axis].fill(query_.ray.direction[axis]);
    }
    rays.unit.fill(query_.ray.unit);
    rays.tmin.fill(query_.tmin);
    rays.tmax.fill(query_.tmax);
    best_.t.fill(query_.best_t);
    packet_.best = &best_;
    packet_.culling = query_.culling;
    packet_.work.fill(0);
  }

  void walk_below(wide::Child root) { walk_every(packet_, root, 0, *this, *this, totals_); }

  /// The corner as the mesh has it: its difference to the center is exact.
  geometry::Vec3f mesh_vertex(const blocks::Block& block, std::size_t i) const {
    return block.vertex(i) + packet_.center;
  }

  bool tightened(bool stop) {
    tighten();
    return stop;
  }

  void tighten() {
    if (!(query_.best_t < best_.t[0])) return;
    best_.t[0] = query_.best_t;
    wide::tighten(packet_, 0);
  }

  lazy::LazyTree& tree_;
  LeafTest& test_;
  MeshQuery& query_;
  lazy::LazyVisit<FloatWalk> visit_;
  wide::Packet packet_;
  wide::BestHits best_;
  wide::WalkTotals totals_;
};

}  // namespace

bool walk_in_floats(lazy::LazyTree& tree, LeafTest& test, kdtree::BuildCounters& built) {
  return FloatWalk(tree, test, built).run();
}

}  // namespace sightline::accel::mesh
