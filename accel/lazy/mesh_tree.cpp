// Triangles under the kd-tree: making references of them, and testing them in its leaves.
#include "accel/lazy/mesh_tree.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

namespace sightline::accel {
namespace {

constexpr std::size_t kFacesPerTask = 16384;

BoxList make_references(const MeshView& mesh, std::uint64_t count, BuildCounters& counters) {
  const std::size_t faces = mesh.faces.size();
  counters.touches_prepare += faces;
  BoxList list(faces);
  const std::span<BoxRef> refs = list.all();
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, faces, kFacesPerTask),
                    [&](const auto& range) {
                      for (std::size_t i = range.begin(); i != range.end(); ++i) {
                        const std::optional<Aabb> box = face_bounds(mesh, i);
                        refs[i] = box ? BoxRef{box->lo, static_cast<std::uint32_t>(i), box->hi, 1}
                                      : BoxRef{{}, 0, {}, 0};
                      }
                    });
  if (count < faces) {
    const auto end =
        std::remove_if(refs.begin(), refs.end(), [](const BoxRef& r) { return r.weight == 0; });
    list.shrink(static_cast<std::size_t>(end - refs.begin()));
  }
  return list;
}

/// What a walk asks at leaves and at cells that are not built.
struct Visit {
  const MeshView& mesh;
  LazyTree& lazy;
  MeshQuery& query;
  const TreeRay& ray;
  WalkCounters& walked;
  BuildCounters& built;

  double limit() const { return query.best_t / query.ray.unit + ray.slack; }

  bool test(std::uint32_t id) {
    ++walked.tests;
    const Face& f = mesh.faces[id];
    const Vec3f &a = mesh.vertices[f[0]], &b = mesh.vertices[f[1]], &c = mesh.vertices[f[2]];
    const std::optional<double> local = intersect(query.ray, a, b, c);
    if (!local) return false;
    const double t = *local * query.ray.unit;
    if (!(t >= query.tmin && t <= query.tmax) || t > query.best_t) return false;
    if (is_culled(query.culling, query.ray, a, b, c)) return false;
    if (query.collects()) {
      collect(t, id);
      return false;
    }
    if (t == query.best_t) {
      if (query.node > query.best_node) return false;
      if (query.node == query.best_node && id >= query.best_primitive) return false;
    }
    query.best_t = t;
    query.best_node = query.node;
    query.best_primitive = id;
    query.best_instance = query.instance;
    query.found = true;
    return query.any;
  }

  void collect(double t, std::uint32_t id) {
    query.found = true;
    if (query.primitives != nullptr) {
      query.primitives->add(id);
    } else if (query.list->add({t, query.node, id, query.instance})) {
      if (const ListedHit* last = query.list->greatest()) query.best_t = last->t;
    }
  }

  bool leaf(std::span<const std::uint32_t> ids) {
    for (const std::uint32_t id : ids) {
      if (test(id)) return true;
    }
    return false;
  }

  Unbuilt unbuilt(AtomicSlot& slot, const DeferredCell& cell) {
    if (query.at_unbuilt == AtUnbuilt::kExpand && lazy.expand(slot, built)) return Unbuilt::kAgain;
    query.met_unbuilt = true;
    if (query.at_unbuilt == AtUnbuilt::kSkip) return Unbuilt::kDone;
    return search(cell) ? Unbuilt::kStop : Unbuilt::kDone;
  }

  bool search(const DeferredCell& cell) {
    if (cell.listed) {
      for (const BoxRef& ref : cell.list.all()) {
        if (may_meet(ray, ref.bounds(), limit()) && test(ref.id)) return true;
      }
      return false;
    }
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      const std::optional<Aabb> box = face_bounds(mesh, i);
      if (box && may_meet(ray, *box, limit()) && test(static_cast<std::uint32_t>(i))) return true;
    }
    return false;
  }
};

}  // namespace

MeshTree::MeshTree(MeshView mesh, const Aabb& bounds, std::uint64_t finite_triangles,
                   const AnyBuilder& builder, [[maybe_unused]] References references)
    : mesh_(mesh),
      lazy_(
          bounds, finite_triangles, builder,
          {.list =
               [mesh, finite_triangles](BuildCounters& counters) {
                 return make_references(mesh, finite_triangles, counters);
               },
           .open = {}},
          &mesh_) {}

void MeshTree::query(MeshQuery& query, WalkCounters& walked, BuildCounters& built) {
  TreeRay ray;
  const double tmax = std::min(query.tmax, query.best_t);
  if (!enter(query.ray, tree().bounds(), query.tmin / query.ray.unit, tmax / query.ray.unit, ray))
    return;
  Visit visit{mesh_, lazy_, query, ray, walked, built};
  walk(tree(), ray, lazy_.root(), walked, visit);
}

std::optional<Aabb> face_bounds(const MeshView& mesh, std::size_t face) {
  const Face& f = mesh.faces[face];
  if (f[0] == kNoVertex) return std::nullopt;
  Aabb box;
  for (const std::uint32_t v : f) {
    const Vec3f& p = mesh.vertices[v];
    if (!is_finite(p)) return std::nullopt;
    box.grow(p);
  }
  return widen_flat(box);
}

MeshBounds mesh_bounds(const MeshView& mesh) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, mesh.faces.size(), kFacesPerTask), MeshBounds{},
      [&](const auto& range, MeshBounds sum) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
          if (const std::optional<Aabb> box = face_bounds(mesh, i)) {
            sum.box.grow(*box);
            ++sum.count;
          }
        }
        return sum;
      },
      [](MeshBounds a, const MeshBounds& b) {
        a.box.grow(b.box);
        a.count += b.count;
        return a;
      });
}

}  // namespace sightline::accel
