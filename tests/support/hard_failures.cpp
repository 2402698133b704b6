// Where methods of the literature exceed the bounds of hard meshes, and why.
#include <algorithm>
#include <vector>

#include "tests/support/hard_meshes.h"

namespace sightline::tests {
namespace {

struct Rule {
  std::vector<std::string_view> builders, meshes;  // No meshes: all
  std::vector<Bound> bounds;
  std::string_view why;

  bool holds(std::string_view mesh, std::string_view builder, Bound bound) const {
    const auto has = [](const auto& list, const auto& item) {
      return std::find(list.begin(), list.end(), item) != list.end();
    };
    return has(builders, builder) && (meshes.empty() || has(meshes, mesh)) && has(bounds, bound);
  }
};

std::vector<Rule> make_rules() {
  using enum Bound;
  const std::vector<std::string_view> medians{"spatial-median", "object-median"};
  const std::vector<std::string_view> exact{"sah-naive", "sah-sort", "sah-sweep"};
  const std::vector<std::string_view> unclipped{"min-max-bins", "scan-one-axis", "scan-hybrid",
                                                "scan-all-axes"};
  const std::vector<std::string_view> overlapping{"slivers", "stacks",       "fan",
                                                  "rods",    "turned-halls", "large-over-small"};
  return {
      {medians,
       overlapping,
       {kReferences, kTouches, kWork, kFailedCells},
       "cuts in the middle though nearly all lies on both sides, and stops at a depth alone"},
      {{"spatial-median"},
       {"rooms", "furnished"},
       {kReferences},
       "cuts beside the walls, and keeps them on both sides"},
      {{"spatial-median"},
       {"stadium", "nested", "halving", "sheet"},
       {kWork},
       "cuts by space alone: empty space is not cut off, and what is crowded stays whole"},
      {{"object-median"},
       {"compact", "wall", "two-walls", "stadium", "nested", "cube", "interleaved", "shell",
        "far-1e5", "far-1e6", "far-1e7", "denormal", "nonfinite", "zero-area", "halving",
        "huge-and-tiny"},
       {kWork},
       "does not weigh areas: cells are as likely large as small, and no empty space is cut off"},
      {exact,
       {"slivers", "stacks", "fan", "rods", "large-over-small", "turned-halls", "nested", "halving",
        "compact", "zero-area"},
       {kReferences, kTouches, kFailedCells},
       "cuts as long as the next cut pays, whatever that takes: there is no budget of references"},
      {{"scan-hybrid", "scan-all-axes"},
       {"fan"},
       {kReferences, kTouches, kWork, kFailedCells},
       "cuts as long as the next cut pays, with boxes that are not clipped"},
      {unclipped,
       {"slivers", "stacks", "fan", "rods", "turned-halls", "large-over-small"},
       {kReferences, kWork},
       "sees boxes, not triangles: a needle's box lies in cells that it does not come near"},
      {{"scan-one-axis"},
       {"fan", "rods"},
       {kTouches},
       "has no other axis to try where the longest offers no cut"},
      {{"bvh-sweep", "bvh-binned", "sbvh"},
       {"slivers", "rods"},
       {kWork},
       "keeps every triangle whole, or splits it too late: boxes of needles lie over each other"},
      {{"sbvh"},
       {"rods", "stacks"},
       {kTouches},
       "tries again and again to split what splitting does not separate"},
      {{"bvh-binned"},
       {"nested", "halving"},
       {kDepth},
       "bins the box of the centres: all but a few are in one bin, scale after scale"},
      {{"bvh-esc"},
       {},
       {kReferences, kTouches, kWork},
       "splits boxes by their size, before it is known whether that separates anything"},
      {{"bvh-evh"},
       {"slivers", "stacks", "fan", "book", "rods", "duplicates", "turned-halls",
        "large-over-small"},
       {kReferences, kTouches, kWork},
       "splits triangles at their edges, before it is known whether that separates anything"},
  };
}

}  // namespace

std::string_view design_failure(std::string_view mesh, std::string_view builder, Bound bound) {
  static const std::vector<Rule> kRules = make_rules();
  for (const Rule& rule : kRules) {
    if (rule.holds(mesh, builder, bound)) return rule.why;
  }
  return {};
}

}  // namespace sightline::tests
