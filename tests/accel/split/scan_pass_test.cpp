// Choosing a cut without the list: through passes that the caller runs, and from earlier counts.
// earlier.
#include "accel/split/scan_pass.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "accel/published/any_builder.h"
#include "tests/accel/boxes.h"

namespace sightline::accel::split {
namespace {

/// A list in pieces of different lengths, one of which is scanned twice, as late helper threads do.
struct Pieces {
  std::span<const kdtree::Reference> refs;
  std::size_t passes = 0;

  PassResult operator()(const PassKernel& kernel) {
    ++passes;
    PassResult sum;
    std::size_t begin = 0;
    for (std::size_t length = 1; begin < refs.size(); length = length * 3 + 1) {
      const auto piece = refs.subspan(begin, std::min(length, refs.size() - begin));
      (void)kernel(piece);
      sum += kernel(piece);
      begin += piece.size();
    }
    return sum;
  }
};

kdtree::ChildScan first_scan(const SplitSearch& rule, std::vector<kdtree::Reference> refs,
                             const geometry::Aabb& cell) {
  // Cut at its lower face, the whole list goes to the right cell.
  std::vector<kdtree::Reference> right(refs.size());
  ChildScans scans{{}, rule.child_planes(cell), {}, {}};
  sift_and_count(refs, {0, cell.lo.x}, refs.data(), right.data(), scans);
  return scans.right;
}

void expect_same_choices(const std::vector<kdtree::Reference>& refs, const geometry::Aabb& cell) {
  for (const std::string_view name : published::builder_names()) {
    const published::AnyBuilder any = *published::make_builder(name);
    const auto* kd = std::get_if<published::KdBuilder>(&any);
    if (kd == nullptr) continue;
    const SplitRule rule = published::plain_rule(*kd).search;
    if (!rule->runs_passes()) continue;
    SCOPED_TRACE(std::string(name) + " " + std::to_string(refs.size()));
    const auto choose = [&](const kdtree::CellRefs& list, kdtree::BuildCounters& counters) {
      return rule->choose(list, counters);
    };
    kdtree::BuildCounters at_hand;
    const auto cut = choose({refs, cell, {}}, at_hand);

    kdtree::BuildCounters through_passes;
    Pieces pieces{refs};
    const RunPass run = std::ref(pieces);
    kdtree::CellRefs list{{}, cell, {}};
    list.size = refs.size();
    list.run = &run;
    EXPECT_EQ(choose(list, through_passes), cut);
    EXPECT_EQ(through_passes.touches, at_hand.touches);
    EXPECT_EQ(pieces.passes * refs.size(), at_hand.touches);

    kdtree::BuildCounters counted_before;
    const kdtree::ChildScan first = first_scan(*rule, refs, cell);
    list.first = &first;
    EXPECT_EQ(choose(list, counted_before), cut);
    EXPECT_LE(counted_before.touches, at_hand.touches - refs.size());
  }
}

TEST(ListPass, ChoosesAsFromTheWholeList) {
  for (const std::size_t n : {257u, 1000u, 70000u}) {
    const auto small = tests::random_boxes(n, 0.01, n);
    expect_same_choices(small, kdtree::bounds_of(small));
    expect_same_choices(tests::lattice_boxes(n, 5, n), {{0, 0, 0}, {5, 5, 5}});
  }
}

TEST(ListPass, IgnoresCountsOfAnotherLength) {
  const auto refs = tests::random_boxes(1000, 0.1, 1);
  kdtree::ChildScan wrong;
  wrong.references = 999;
  kdtree::CellRefs list{refs, kdtree::bounds_of(refs), {}};
  kdtree::BuildCounters counters, expected;
  const ScanSplit scan = scan_fast();
  const auto cut = scan.choose(list, expected);
  list.first = &wrong;
  EXPECT_EQ(scan.choose(list, counters), cut);
  EXPECT_EQ(counters.touches, expected.touches);
}

}  // namespace
}  // namespace sightline::accel::split
