// calibrate: what the rule of demand compares, measured: searching a list, dividing a cell, making
// leaf blocks of one. accel/lazy/demand.h has the constants.
#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "accel/grow/subtrees.h"
#include "accel/kdtree/box_filter.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/face_references.h"
#include "accel/mesh/face_test.h"
#include "accel/split/split_rule.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"
#include "tests/support/mesh_query.h"

namespace sightline::bench {
namespace {

using accel::geometry::LocalRay;
using accel::kdtree::AtomicSlot;
using accel::kdtree::Reference;
using accel::lazy::LazyTree;
using accel::mesh::FaceTest;

// The triangles of a scene as one mesh.
struct Subject {
  accel::geometry::MeshView mesh;
  accel::mesh::MeshStats stats;
  std::vector<LocalRay> rays;
};

// A query of the whole mesh by one ray that meets its box.
struct OneRay {
  OneRay(const Subject& subject, const LocalRay& ray) : bounds(padded(subject.stats.bounds)) {
    best.clear();
    packet->best = &best;
    packet->work.fill(0);
    tests::set_ray(ray, 0, std::numeric_limits<double>::max(), packet->rays);
    test.emplace(subject.mesh, bounds, *packet, 0, cells, walked);
  }
  OneRay(const OneRay&) = delete;
  OneRay& operator=(const OneRay&) = delete;

  const accel::geometry::Aabb bounds;
  const std::unique_ptr<accel::wide::Packet> packet = std::make_unique<accel::wide::Packet>();
  accel::wide::BestHits best;
  accel::lazy::CellQuery cells;
  accel::kdtree::WalkCounters walked;
  std::optional<FaceTest> test;
};

double seconds_of(const std::function<void()>& work) {
  const Stopwatch clock;
  work();
  return clock.seconds();
}

// All boxes and nothing else: the least that a search must read. Of one ray, in seconds.
double pass_over_boxes(const Subject& subject, std::span<const Reference> refs) {
  const OneRay one(subject, subject.rays.front());
  const accel::kdtree::FilterRay filter = accel::kdtree::filter_ray(one.test->ray().in_tree());
  std::uint64_t met = 0;
  const double seconds = seconds_of([&] {
    for (std::size_t i = 0; i < refs.size(); i += accel::kdtree::kFilterBatch) {
      met |= accel::kdtree::may_meet_mask(
          filter, refs.subspan(i, std::min(accel::kdtree::kFilterBatch, refs.size() - i)));
    }
  });
  // The result is used, so that the pass is made.
  return met == 0 ? std::max(seconds, 1e-9) : seconds;
}

// The mean over the rays.
template <class Search>
double search(const Subject& subject, const Search& each) {
  double seconds = 0;
  for (const LocalRay& ray : subject.rays) {
    OneRay one(subject, ray);
    seconds += seconds_of([&] { each(*one.test); });
  }
  return seconds / static_cast<double>(subject.rays.size());
}

struct Expansions {
  double seconds = 0;
  std::uint64_t references = 0, cells = 0;
};

// Expands all cells one by one: how long divisions take, and leaf blocks.
class Growth {
 public:
  explicit Growth(LazyTree& tree) : tree_(tree) {}

  void below(AtomicSlot& slot) {
    for (;;) {
      const accel::kdtree::EpochPin pin;
      const accel::kdtree::Slot now = accel::kdtree::load(slot);
      if (!now.is_deferred()) break;
      const accel::kdtree::DeferredCell& cell = *now.cell();
      Expansions& kind = cell.weight <= accel::grow::kBlockCell ? finished : divided;
      kind.references += &kind == &finished ? cell.weight : cell.size;
      ++kind.cells;
      accel::kdtree::BuildCounters built;
      kind.seconds += seconds_of([&] { tree_.expand(slot, built); });
    }
    const accel::kdtree::Slot now = accel::kdtree::load(slot);
    if (!now.is_node()) return;
    for (std::size_t i = 0; i < accel::kdtree::kWidth && now.node()->child(i); ++i)
      below(now.node()->slot(i));
  }

  Expansions divided, finished;

 private:
  LazyTree& tree_;
};

}  // namespace

Result<std::vector<Row>> run_calibrate(const CommonOptions& common) {
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  const SceneSource one = merged(*scene);
  if (one.meshes.empty()) {
    return Error{Code::kFailedPrecondition, "the scene has no triangles", "NO_TRIANGLES"};
  }
  Subject subject{{one.meshes[0].vertices, one.meshes[0].faces}, {}, {}};
  subject.stats = accel::mesh::compute_mesh_stats(subject.mesh);
  subject.mesh.all_finite = subject.stats.finite_triangles == subject.mesh.faces.size();
  const auto rays = make_rays(one, {"random", 16}, common.seed);
  if (!rays.ok()) return rays.error();
  for (const accel::geometry::Ray& ray : *rays)
    subject.rays.push_back(*accel::geometry::make_local_ray(ray.origin, ray.direction));

  const std::size_t faces = subject.mesh.faces.size();
  std::vector<Reference> refs(faces);
  refs.resize(accel::mesh::face_references(subject.mesh, 0, faces, refs.data()));

  std::vector<double> pass, everything, list, divide, finish;
  std::uint64_t divided = 0, finished = 0;
  for (int repeat = 0; repeat < common.repeat; ++repeat) {
    pass.push_back(pass_over_boxes(subject, refs));
    everything.push_back(search(subject, [](FaceTest& test) { test.everything(); }));
    list.push_back(search(subject, [&](FaceTest& test) { test.references(refs); }));
    LazyTree tree(padded(subject.stats.bounds), subject.stats.finite_triangles,
                  accel::split::default_rule(),
                  accel::mesh::source_of_faces(subject.mesh, subject.stats.bounds, true, nullptr),
                  &subject.mesh);
    Growth growth(tree);
    growth.below(tree.root());
    divide.push_back(growth.divided.seconds);
    finish.push_back(growth.finished.seconds);
    divided = growth.divided.references;
    finished = growth.finished.references;
  }
  std::vector<Row> rows;
  const double unit = median(list) / static_cast<double>(refs.size());
  const auto add = [&](const char* what, const std::vector<double>& seconds,
                       std::uint64_t references) {
    const double each =
        median(seconds) / static_cast<double>(std::max<std::uint64_t>(references, 1));
    Row row;
    row["scene"] = common.scene;
    row["what"] = what;
    row["references"] = references;
    row["ms"] = median(seconds) * 1e3;
    row["ns_per_reference"] = each * 1e9;
    row["over_list"] = each / unit;
    rows.push_back(std::move(row));
  };
  add("pass over boxes", pass, refs.size());
  add("one ray, all faces", everything, faces);
  add("one ray, a list", list, refs.size());
  add("divide", divide, divided);
  add("finish", finish, finished);
  return rows;
}

}  // namespace sightline::bench
