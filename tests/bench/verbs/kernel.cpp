// kernel: the throughput of the builder's inner loops in boxes a second, from L2 and from memory.
#include <algorithm>
#include <functional>

#include "accel/kdtree/sift.h"
#include "accel/split/child_scan.h"
#include "accel/split/scan_kernel.h"
#include "tests/bench/verbs/stopwatch.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/support/random.h"

namespace sightline::bench {
namespace {

using accel::kdtree::kUniformPlanes;
using accel::kdtree::PlaneCounts;
using accel::kdtree::Reference;
using accel::split::kScanWidth;
using accel::split::UniformAxis;
using tests::Random;

constexpr double kSecondsPerRun = 0.05;
// Throughput of a loop over 16 planes of 3 axes from L2 on the machine of docs/benchmarks.md.
constexpr double kBestComparisons = 490e6 * 16 * 3;

// Small boxes all over the unit cube.
std::vector<Reference> random_boxes(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Reference> boxes(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    Reference& box = boxes[i];
    box.id = i;
    for (std::size_t a = 0; a < 3; ++a) {
      box.lo[a] = static_cast<float>(random.uniform());
      box.hi[a] = box.lo[a] + static_cast<float>(random.uniform(1e-4, 1e-2));
    }
  }
  return boxes;
}

// One loop over the boxes, and a check of its result against plain counting.
struct Pass {
  const char* name;
  std::size_t planes = 0, axes = 0;
  std::function<void()> run;
  std::function<bool()> is_right;
};

template <std::size_t kPlanes, class Axis>
bool counts_right(std::span<const Reference> boxes, std::size_t axis, const Axis& planes,
                  const PlaneCounts<kPlanes>& counts) {
  for (std::size_t p = 0; p < kPlanes; ++p) {
    std::uint32_t left = 0, right = 0;
    for (const Reference& box : boxes) {
      left += box.lo[axis] < planes[p] ? box.weight : 0;
      right += box.hi[axis] > planes[p] ? box.weight : 0;
    }
    if (left != counts.left[p] || right != counts.right[p]) return false;
  }
  return true;
}

// Buffers and planes of all passes over one list.
class Bench {
 public:
  explicit Bench(std::size_t count, std::uint64_t seed)
      : boxes_(random_boxes(count, seed)), left_(count), right_(count) {
    const accel::geometry::Aabb cube{{0, 0, 0}, {1, 1, 1}};
    few_ = accel::split::child_planes(cube, kUniformPlanes).at;
    for (std::size_t p = 0; p < kScanWidth; ++p) {
      wide_[p] = (static_cast<float>(p) + 0.5f) / static_cast<float>(kScanWidth);
    }
    scans_.left_planes = accel::split::child_planes({{0, 0, 0}, {kCut, 1, 1}}, kUniformPlanes);
    scans_.right_planes = accel::split::child_planes({{kCut, 0, 0}, {1, 1, 1}}, kUniformPlanes);
  }

  std::vector<Pass> passes() {
    return {{"scan-three-axes", kUniformPlanes, 3, [this] { scan_three(); },
             [this] {
               bool right = true;
               for (std::size_t a = 0; a < 3; ++a) {
                 right = right && counts_right(boxes_, a, few_[a], three_[a]);
               }
               return right;
             }},
            {"scan-one-axis", kUniformPlanes, 1, [this] { scan_one(); },
             [this] { return counts_right(boxes_, 0, few_[0], one_); }},
            {"scan-wide-axis", kScanWidth, 1, [this] { scan_wide(); },
             [this] { return counts_right(boxes_, 0, wide_, many_) && neighbours_right(); }},
            {"sift", 1, 1, [this] { sift(); }, [this] { return sift_is_right(); }},
            {"sift-and-scan", kUniformPlanes, 3, [this] { sift_and_count(); },
             [this] { return sift_is_right() && scans_right(); }}};
  }

  std::size_t size() const { return boxes_.size(); }

 private:
  static constexpr float kCut = 0.5f;

  void scan_three() {
    three_ = {};
    accel::split::scan_three_axes(boxes_, few_, three_);
  }
  void scan_one() {
    one_ = {};
    accel::split::scan_one_axis(boxes_, 0, few_[0], one_);
  }
  void scan_wide() {
    many_ = {};
    near_ = {};
    accel::split::scan_wide_axis(boxes_, 0, wide_, many_, near_);
  }
  void sift() { counts_ = accel::kdtree::sift(boxes_, {{0, kCut}}, left_.data(), right_.data()); }
  void sift_and_count() {
    scans_.left = scans_.right = {};
    counts_ = accel::split::sift_and_count(boxes_, {0, kCut}, left_.data(), right_.data(), scans_);
  }

  bool neighbours_right() const {
    accel::split::PlaneNeighbours near;
    for (std::size_t p = 0; p < kScanWidth; ++p) {
      for (const Reference& box : boxes_) {
        const float x = wide_[p], lo = box.lo[0], hi = box.hi[0];
        if (lo < x) near.below[p] = std::max(near.below[p], lo);
        if (hi <= x) near.below[p] = std::max(near.below[p], hi);
        if (lo >= x) near.above[p] = std::min(near.above[p], lo);
        if (hi > x) near.above[p] = std::min(near.above[p], hi);
      }
    }
    return near == near_;
  }

  bool sift_is_right() const {
    std::size_t left = 0, right = 0;
    for (const Reference& box : boxes_) {
      if (box.lo[0] < kCut && (left == counts_.left || left_[left++].id != box.id)) return false;
      if (box.hi[0] > kCut && (right == counts_.right || right_[right++].id != box.id)) {
        return false;
      }
    }
    return left == counts_.left && right == counts_.right;
  }

  bool scans_right() const {
    const std::span<const Reference> left(left_.data(), counts_.left);
    const std::span<const Reference> right(right_.data(), counts_.right);
    for (std::size_t a = 0; a < 3; ++a) {
      if (!counts_right(left, a, scans_.left_planes.at[a], scans_.left.axes[a]) ||
          !counts_right(right, a, scans_.right_planes.at[a], scans_.right.axes[a])) {
        return false;
      }
    }
    return true;
  }

  std::vector<Reference> boxes_, left_, right_;
  std::array<UniformAxis, 3> few_{};
  accel::split::WideAxis wide_{};
  std::array<PlaneCounts<kUniformPlanes>, 3> three_;
  PlaneCounts<kUniformPlanes> one_;
  PlaneCounts<kScanWidth> many_;
  accel::split::PlaneNeighbours near_;
  accel::kdtree::PartitionCounts counts_;
  accel::split::ChildScans scans_{};
};

// Boxes a second over many passes in sequence.
double measure(const Pass& pass, std::size_t boxes) {
  std::size_t passes = 0;
  const Stopwatch clock;
  double seconds = 0;
  while (seconds < kSecondsPerRun) {
    pass.run();
    ++passes;
    seconds = clock.seconds();
  }
  return static_cast<double>(boxes * passes) / seconds;
}

}  // namespace

Result<std::vector<Row>> run_kernel(const CommonOptions& common, const KernelOptions& options) {
  std::vector<Row> rows;
  for (const std::size_t count : options.boxes) {
    Bench bench(count, common.seed);
    for (const Pass& pass : bench.passes()) {
      pass.run();
      if (!pass.is_right()) {
        return Error{Code::kDataLoss,
                     std::string(pass.name) + " disagrees with counting one by one", "MISMATCH"};
      }
      std::vector<double> rates;
      for (int repeat = 0; repeat < common.repeat; ++repeat) {
        rates.push_back(measure(pass, count));
      }
      const double rate = median(rates);
      const auto comparisons = static_cast<double>(pass.planes * pass.axes);
      Row row;
      row["pass"] = pass.name;
      row["target"] = accel::split::simd_target();
      row["boxes"] = count;
      row["kib"] = count * sizeof(Reference) / 1024;
      row["planes"] = pass.planes;
      row["axes"] = pass.axes;
      row["mboxes_per_s"] = rate / 1e6;
      row["mboxes_per_s_max"] = *std::max_element(rates.begin(), rates.end()) / 1e6;
      row["gbytes_per_s"] = rate * sizeof(Reference) / 1e9;
      row["of_490_mboxes_16x3"] = rate * comparisons / kBestComparisons;
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

}  // namespace sightline::bench
