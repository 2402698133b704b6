// The error bounds of sampled C_L and C_R: those of Appendix A, with their constants.
// A function that only rises, by r over a segment of width w, differs from the line between its
// ends by an area of at most w r / 2: a step at one end is the worst case. C_L and -C_R only rise,
// and F = C_L - C_R rises by the sum of both rises. So every bound on F's segments (w r / 2 with r
// the rise of F) holds for C_L, for C_R, and, without the paper's factor of two, for the sum of
// their errors. Let a and b be the cell's faces, R = F(b) - F(a), and q the number of uniform
// samples.
// A.2, all segments: the sum of w r / 2 is at most (b - a) R / (2 (q - 1)), as every w is at most
// (b - a) / (q - 1).
// A.3, n more adaptive samples: a segment of the first pass that rises by r holds more than n r / R
// - 1 of the n teeth. It is cut into at least n r / R pieces, so each has w <= (b - a) / (q - 1) *
// R / (n r) and rises by at most r: w r / 2 <= (b - a) R / (2 (q - 1) n), wherever the rise is.
#include "accel/published/kd/scan_samples.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "accel/published/kd/hunt_scan.h"
#include "tests/accel/boxes.h"
#include "tests/support/cost_curve.h"

namespace sightline::accel::published::kd {
namespace {

using tests::SampleSegment;
using tests::TrueCounts;

// Sample positions are floats: this share of a bound allows for rounding.
constexpr double kRounding = 1 + 1e-4;

struct Soup {
  std::string name;
  std::vector<kdtree::Reference> refs;
};

const geometry::Aabb kUnitCell{{0, 0, 0}, {1, 1, 1}};

kdtree::Reference slab(double lo, double hi, std::uint32_t weight = 1) {
  return tests::box_ref({static_cast<float>(lo), 0, 0}, {static_cast<float>(hi), 1, 1}, 0, weight);
}

/// `count` thin boxes side by side, filling [0, 1].
void add_row(std::vector<kdtree::Reference>& refs, int count) {
  for (int i = 0; i < count; ++i)
    refs.push_back(slab(i / static_cast<double>(count), (i + 1) / static_cast<double>(count)));
}

std::vector<Soup> soups(std::uint64_t seed) {
  tests::Random random(seed);
  Soup smooth{"smooth", {}}, step{"step", {}}, hat{"hat", {}}, weighted{"weighted", {}},
      faces{"at the faces", {}};
  add_row(smooth.refs, 1000);
  const double wall = random.uniform(0.02, 0.98), thickness = random.uniform(0.01, 0.3);
  add_row(step.refs, 100);
  add_row(hat.refs, 100);
  for (int i = 0; i < 400; ++i) {
    step.refs.push_back(slab(wall, wall));
    hat.refs.push_back(slab(wall, wall + thickness));  // May end beyond the cell
    const double at = random.uniform() * random.uniform();
    weighted.refs.push_back(
        slab(at, at + 0.1 * random.uniform(), static_cast<std::uint32_t>(1 + random.below(1000))));
    faces.refs.push_back(i % 2 == 0 ? slab(0, 0) : slab(1, 1));
  }
  return {smooth,
          step,
          hat,
          weighted,
          faces,
          {"random, small", tests::random_boxes(2000, 0.01, seed)},
          {"random, large", tests::random_boxes(300, 1.0, seed)},
          {"lattice", tests::lattice_boxes(200, 9, seed)}};
}

Samples sample(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell,
               std::uint32_t uniform, std::uint32_t adaptive) {
  kdtree::BuildCounters counters;
  return sample_axes(refs, cell, {0, 1}, uniform, adaptive, counters)[0];
}

/// The area between two lines that differ by d0 and d1 at the ends of an interval.
double area_between(double d0, double d1, double width) {
  if (d0 * d1 >= 0) return width * (std::abs(d0) + std::abs(d1)) / 2;
  return width * (d0 * d0 + d1 * d1) / (2 * (std::abs(d0) + std::abs(d1)));
}

struct Errors {
  double left = 0, right = 0;
};

/// Integrals of |C_L - its line| and |C_R - its line| over a segment, exact: between steps the true
/// functions are constant.
Errors integrate(const TrueCounts& truth, const SampleSegment& segment) {
  Errors errors;
  std::vector<double> stops{segment.begin.position};
  for (const double x : truth.steps()) {
    if (x > segment.begin.position && x < segment.end.position) stops.push_back(x);
  }
  stops.push_back(segment.end.position);
  for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
    const double p = stops[i], q = stops[i + 1], middle = p + (q - p) / 2;
    const double left = truth.left(middle), right = truth.right(middle);
    errors.left += area_between(left - segment.left(p), left - segment.left(q), q - p);
    errors.right += area_between(right - segment.right(p), right - segment.right(q), q - p);
  }
  return errors;
}

double whole_rise(const Samples& samples) {
  const Sample &first = samples.at[0], &last = samples.at[samples.size - 1];
  return (last.left - last.right) - (first.left - first.right);
}

template <class Check>
void for_all_soups(const Check& check) {
  for (std::uint64_t seed = 1; seed <= 25; ++seed) {
    for (const Soup& soup : soups(seed)) {
      SCOPED_TRACE(soup.name + ", seed " + std::to_string(seed));
      // A cell that shares faces with boxes, one that boxes exceed, and the whole list.
      for (const geometry::Aabb& cell :
           {kUnitCell, geometry::Aabb{{0.2f, 0, 0}, {0.7f, 1, 1}}, kdtree::bounds_of(soup.refs)}) {
        std::vector<kdtree::Reference> inside;
        for (const kdtree::Reference& ref : soup.refs) {
          if (is_member(ref.bounds(), cell)) inside.push_back(ref);
        }
        if (!inside.empty()) check(inside, cell);
      }
    }
  }
}

TEST(ScanSamples, AreTheTrueCountsIncludingTheCellsFaces) {
  for_all_soups([](const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell) {
    const TrueCounts truth(refs, 0);
    for (const auto& [uniform, adaptive] : {std::pair(8u, 0u), {8u, 8u}, {9u, 13u}, {16u, 16u}}) {
      const Samples samples = sample(refs, cell, uniform, adaptive);
      ASSERT_GE(samples.size, uniform);
      ASSERT_LE(samples.size, uniform + adaptive);
      EXPECT_EQ(samples.at[0].position, static_cast<double>(cell.lo[0]));
      EXPECT_EQ(samples.at[samples.size - 1].position, static_cast<double>(cell.hi[0]));
      for (std::size_t i = 0; i < samples.size; ++i) {
        const Sample& s = samples.at[i];
        EXPECT_EQ(s.left, truth.left(s.position));
        EXPECT_EQ(s.right, truth.right(s.position));
        EXPECT_LE(samples.at[i > 0 ? i - 1 : 0].position, s.position);
      }
    }
  });
}

// Boxes that begin at a face lie above it: a plane there has no reference on its outer side.
TEST(ScanSamples, CountStrictlyAtTheFaces) {
  const std::vector<kdtree::Reference> refs{slab(0, 0.5), slab(0, 1), slab(0.5, 1)};
  const Samples samples = sample(refs, kUnitCell, 2, 0);
  EXPECT_EQ(samples.at[0].left, 0);
  EXPECT_EQ(samples.at[0].right, 3);
  EXPECT_EQ(samples.at[1].left, 3);
  EXPECT_EQ(samples.at[1].right, 0);
}

TEST(ScanSamples, APassCountsEightPlanes) {
  const std::vector<kdtree::Reference> refs = tests::random_boxes(1000, 0.01, 1);
  for (const auto& [uniform, adaptive, passes] :
       {std::tuple(2u, 0u, 1u), {8u, 8u, 2u}, {9u, 8u, 3u}, {16u, 16u, 4u}}) {
    kdtree::BuildCounters counters;
    (void)sample_axes(refs, kUnitCell, {}, uniform, adaptive, counters);
    EXPECT_EQ(counters.touches, passes * refs.size());
  }
}

TEST(ScanSamples, UniformSamplesKeepTheErrorBelowOneOverN) {
  for_all_soups([](const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell) {
    const TrueCounts truth(refs, 0);
    for (std::uint32_t n = 2; n <= kMostSamples; ++n) {
      const Samples samples = sample(refs, cell, n, 0);
      const double width = static_cast<double>(cell.hi[0]) - static_cast<double>(cell.lo[0]);
      const double per_rise = kRounding * width / (2 * (n - 1));
      Errors sum;
      for (const SampleSegment& segment : tests::segments(samples)) {
        const Errors e = integrate(truth, segment);
        sum.left += e.left;
        sum.right += e.right;
      }
      const Sample &a = samples.at[0], &b = samples.at[samples.size - 1];
      EXPECT_LE(sum.left, per_rise * (b.left - a.left));
      EXPECT_LE(sum.right, per_rise * (a.right - b.right));
    }
  });
}

TEST(ScanSamples, NoSegmentIsOffByMoreThanHalfWidthTimesRise) {
  for_all_soups([](const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell) {
    const TrueCounts truth(refs, 0);
    for (const SampleSegment& segment : tests::segments(sample(refs, cell, 8, 8))) {
      const Errors e = integrate(truth, segment);
      EXPECT_LE(e.left + e.right, kRounding * segment.width() * segment.rise() / 2);
    }
  });
}

TEST(ScanSamples, AdaptiveSamplesKeepEverySegmentBelowOneOverNSquared) {
  for_all_soups([](const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell) {
    for (std::uint32_t n = 2; n <= kMostSamples; ++n) {
      const Samples samples = sample(refs, cell, n, n);
      const double width = static_cast<double>(cell.hi[0]) - static_cast<double>(cell.lo[0]);
      for (const SampleSegment& segment : tests::segments(samples)) {
        EXPECT_LE(segment.width() * segment.rise() / 2,
                  kRounding * width * whole_rise(samples) / (2.0 * (n - 1) * n));
      }
    }
  });
}

// A segment with the share s of the rise is cut into at least n s pieces: the larger a
// discontinuity, the narrower the segment that contains it.
TEST(ScanSamples, AreDenseAtADiscontinuity) {
  for (const double wall : {0.05, 0.31, 0.5, 0.77}) {
    for (const int weight : {100, 1000, 10000}) {
      std::vector<kdtree::Reference> refs;
      add_row(refs, 500);
      for (int i = 0; i < weight; ++i) refs.push_back(slab(wall, wall));
      const auto segments = tests::segments(sample(refs, kUnitCell, 8, 8));
      const double share = weight / (weight + 500.0);
      EXPECT_LE(tests::segment_at(segments, static_cast<double>(refs.back().hi.x)).width(),
                kRounding / 7 / std::max(1.0, 8 * share));
    }
  }
}

/// The cost along one axis, exact and from the samples. Without the bonus for empty sides, which
/// Appendix A does not have.
class CostAlongAxis {
 public:
  CostAlongAxis(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell)
      : builder_{.axes = ScanAxes::kOne, .exact_below = 0, .cost = {.empty_bonus = 1}},
        areas_(cell, 0),
        truth_(refs, 0),
        segments_(tests::segments(
            sample(refs, cell, builder_.uniform_samples, builder_.adaptive_samples))) {}

  double real(double x) const {
    return split_cost(builder_.cost, areas_, x, truth_.left(x), truth_.right(x));
  }
  double suggested(double x) const {
    const SampleSegment& s = segment(x);
    return split_cost(builder_.cost, areas_, x, s.left(x), s.right(x));
  }
  const SampleSegment& segment(double x) const { return tests::segment_at(segments_, x); }
  const std::vector<double>& steps() const { return truth_.steps(); }
  const HuntScan& builder() const { return builder_; }

 private:
  HuntScan builder_;
  split::SplitAreas areas_;
  TrueCounts truth_;
  std::vector<SampleSegment> segments_;
};

// Both probabilities are at most one, so at every x the cost is off by no more than the rise of x's
// segment. Multiplied by the segment's width, within which the plane is known, this is at most (b -
// a) R / ((q - 1) n): A.4.
TEST(ScanSamples, CostIsOffByNoMoreThanTheRiseOfTheSegment) {
  for_all_soups([](const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell) {
    const CostAlongAxis cost(refs, cell);
    for (const double step : cost.steps()) {
      for (const double x : {step, step + 1e-4}) {
        if (x <= static_cast<double>(cell.lo[0]) || x >= static_cast<double>(cell.hi[0])) continue;
        EXPECT_LE(std::abs(cost.real(x) - cost.suggested(x)),
                  cost.segment(x).rise() * (1 + 1e-9) + 1e-9);
      }
    }
  });
}

struct Optimum {
  double at = 0, cost = 0;
};

/// Between steps the cost is linear, and it is semicontinuous at them, so the minimum lies at a
/// step.
Optimum true_optimum(const CostAlongAxis& cost, const geometry::Aabb& cell) {
  Optimum best{0, 1e300};
  for (const double x : cost.steps()) {
    if (x <= static_cast<double>(cell.lo[0]) || x >= static_cast<double>(cell.hi[0])) continue;
    if (const double c = cost.real(x); c < best.cost) best = {x, c};
  }
  return best;
}

// The sampled cost is least at the chosen plane, so the true cost there exceeds the optimum by at
// most the sum of both errors.
TEST(ScanSamples, TheChosenPlaneIsNearlyOptimal) {
  for_all_soups([](const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell) {
    const CostAlongAxis cost(refs, cell);
    if (cell.hi.x - cell.lo.x < std::max(cell.hi.y - cell.lo.y, cell.hi.z - cell.lo.z)) return;
    kdtree::BuildCounters counters;
    const auto cut = cost.builder().choose({refs, cell, {}}, counters);
    const Optimum best = true_optimum(cost, cell);
    if (!cut || best.cost == 1e300) return;
    const double x = static_cast<double>(cut->plane.position);
    EXPECT_LE(cost.real(x) - best.cost,
              (cost.segment(x).rise() + cost.segment(best.at).rise()) * (1 + 1e-6) + 1e-6);
  });
}

// A wall of at least two thirds of the weight in an evenly filled cell. With M boxes in the wall
// and S beside it, the true cost falls toward the wall from both sides (its slope is proportional
// to 2 S (2x - 1) -+ M, with M >= 2 S), so the best plane is at the wall, and the chosen one is in
// the wall's segment or at its ends. Then their distance is at most the segment's width w, the
// excess cost at most twice its rise r, and their product at most 2 w r <= 2 (b - a) R / ((q - 1)
// n).
TEST(ScanSamples, DistanceTimesExcessIsBoundedAtAWall) {
  tests::Random random(17);
  for (int trial = 0; trial < 500; ++trial) {
    const double wall = random.uniform(0.02, 0.98);
    const int beside = 50 + static_cast<int>(random.below(500));
    const int boxes = 2 * beside + static_cast<int>(random.below(5000));
    std::vector<kdtree::Reference> refs;
    add_row(refs, beside);
    for (int i = 0; i < boxes; ++i) refs.push_back(slab(wall, wall));
    const CostAlongAxis cost(refs, kUnitCell);
    kdtree::BuildCounters counters;
    const auto cut = cost.builder().choose({refs, kUnitCell, {}}, counters);
    ASSERT_TRUE(cut) << "wall at " << wall << ", " << boxes << " boxes, " << beside << " beside it";
    const Optimum best = true_optimum(cost, kUnitCell);
    const double x = static_cast<double>(cut->plane.position);
    const SampleSegment& caught = cost.segment(best.at);
    const double distance = std::abs(x - best.at), excess = cost.real(x) - best.cost;
    EXPECT_LE(distance, kRounding * std::max(caught.width(), cost.segment(x).width()));
    const double rise = 2.0 * (boxes + beside);
    EXPECT_LE(distance * excess, kRounding * 2 * rise / (7 * 8))
        << "wall at " << wall << ", " << boxes << " boxes, " << beside << " beside it";
  }
}

}  // namespace
}  // namespace sightline::accel::published::kd
