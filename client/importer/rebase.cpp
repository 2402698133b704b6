// Subtracts offsets from vertices and adds them to transforms.
//
// Why no vertex is rounded if all are floats: let v be a coordinate on an axis with offset c. v is
// at most half an extent away from the middle, and c at most half a step, so |v - c| is at most one
// step. |v| is at least kFar steps. So c/2 <= v <= 2c, and the difference of two such numbers is
// exact in double (Sterbenz). The difference is a multiple of the last bit of v or of the step,
// whichever is smaller. In the first case it has fewer bits than v; in the second it is a step or
// zero. In both cases it is a float.
#include "client/importer/rebase.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <utility>

#include "client/importer/finite.h"
#include "client/importer/lattice.h"
#include "client/importer/node_name.h"

namespace sightline::client::importer {
namespace {

constexpr double kFloatLoss = 0x1p-24;  // share of a mesh's size
constexpr double kFarTooCoarse = 1e-2;  // share of a mesh's size; beyond, it has its own step

bool is_float(double x) { return static_cast<double>(static_cast<float>(x)) == x; }

Point exact_offset(const VertexBox& box) {
  Point offset{};
  const double extent = box.size();
  if (!(extent > 0)) return offset;
  int exponent = 0;
  std::frexp(extent, &exponent);
  const double step = std::ldexp(1.0, exponent);
  for (std::size_t k = 0; k < 3; ++k) {
    // Below 0 if 0 is between the bounds
    const double nearest = std::max(box.lo[k], -box.hi[k]);
    if (nearest < kFar * step) continue;
    const double middle = box.lo[k] + (box.hi[k] - box.lo[k]) / 2;
    offset[k] = std::round(middle / step) * step;
  }
  return offset;
}

// Returns nothing if the result needs rounding, as exact_product and `moved` do.
std::optional<double> exact_sum(double a, double b) {
  const double sum = a + b;
  const double of_b = sum - a;
  const double lost = (a - (sum - of_b)) + (b - of_b);
  if (lost == 0) return sum;
  return std::nullopt;
}

std::optional<double> exact_product(double a, double b) {
  const double product = a * b;
  if (std::fma(a, b, -product) == 0) return product;
  return std::nullopt;
}

// `rows` after a translation by the offset.
std::optional<std::array<double, 12>> moved(std::array<double, 12> rows, const Point& offset) {
  for (std::size_t r = 0; r < 3; ++r) {
    double& translation = rows[4 * r + 3];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto part = exact_product(rows[4 * r + k], offset[k]);
      const auto sum = part ? exact_sum(translation, *part) : std::nullopt;
      if (!sum) return std::nullopt;
      translation = *sum;
    }
  }
  return rows;
}

// The nodes with the offsets of their meshes added, or nothing if some node cannot hold it exactly.
std::optional<std::vector<ImportedNode>> moved(std::vector<ImportedNode> nodes,
                                               const std::vector<Point>& offsets) {
  if (std::all_of(offsets.begin(), offsets.end(), [](const Point& o) { return o == Point{}; }))
    return nodes;
  for (const ImportedNode& node : nodes) {
    if (node.parent != kNone && nodes[node.parent].mesh != kNone) return std::nullopt;
  }
  for (ImportedNode& node : nodes) {
    if (node.mesh == kNone) continue;
    const auto rows = moved(node.parent_from_local, offsets[node.mesh]);
    if (!rows) return std::nullopt;
    node.parent_from_local = *rows;
  }
  return nodes;
}

bool are_floats(const std::vector<FileMesh>& meshes) {
  return std::all_of(meshes.begin(), meshes.end(), [](const FileMesh& mesh) {
    return std::all_of(mesh.vertices.begin(), mesh.vertices.end(), [](const Point& v) {
      return !is_finite(v) || std::all_of(v.begin(), v.end(), is_float);
    });
  });
}

// Whether the rest of every vertex is a float.
bool is_exact(const std::vector<FileMesh>& meshes, const std::vector<Point>& offsets) {
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    for (const Point& v : meshes[m].vertices) {
      for (std::size_t k = 0; k < 3 && is_finite(v); ++k) {
        const auto rest = exact_sum(v[k], -offsets[m][k]);
        if (!rest || !is_float(*rest)) return false;
      }
    }
  }
  return true;
}

void subtract_exactly(std::vector<FileMesh>& meshes, const std::vector<Point>& offsets) {
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    if (offsets[m] == Point{}) continue;
    for (Point& v : meshes[m].vertices) {
      for (std::size_t k = 0; k < 3 && is_finite(v); ++k) v[k] -= offsets[m][k];
    }
  }
}

// Returns how far a vertex was moved, at most. Beyond the range of floats there is no distance.
double round_and_subtract(FileMesh& mesh, const LatticeStep& step, const Point& offset) {
  double largest = 0;
  for (Point& v : mesh.vertices) {
    for (std::size_t k = 0; k < 3 && is_finite(v); ++k) {
      const auto rest = static_cast<double>(static_cast<float>(step.rounded(v[k]) - offset[k]));
      const double loss = std::abs(rest + offset[k] - v[k]);
      if (std::isfinite(loss)) largest = std::max(largest, loss);
      v[k] = rest;
    }
  }
  return largest;
}

struct Scene {
  explicit Scene(const std::vector<FileMesh>& meshes) {
    for (const FileMesh& mesh : meshes) {
      boxes.push_back(box_of(mesh));
      box.add(boxes.back());
      largest = std::max(largest, boxes.back().size());
    }
  }

  std::vector<VertexBox> boxes;  // the meshes' boxes
  VertexBox box;                 // the box of all
  double largest = 0;            // the size of the largest mesh
};

// The meshes from the largest to the smallest; each takes the last step, if that is not far too
// coarse for it.
std::vector<LatticeStep> choose_steps(const Scene& scene, std::size_t& own_steps) {
  const std::vector<VertexBox>& boxes = scene.boxes;
  std::vector<std::size_t> order(boxes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return boxes[a].size() > boxes[b].size(); });
  LatticeStep step(scene.largest, scene.box.reach());
  std::vector<LatticeStep> steps(boxes.size(), step);
  own_steps = 0;
  for (const std::size_t m : order) {
    const double size = boxes[m].size();
    if (size > 0 && step.error(boxes[m].reach()) > kFarTooCoarse * size) {
      step = LatticeStep(size, boxes[m].reach());
      ++own_steps;
    }
    steps[m] = step;
  }
  return steps;
}

std::vector<Point> choose_offsets(const Scene& scene, const std::vector<LatticeStep>& steps) {
  const bool is_small = std::all_of(steps.begin(), steps.end(), [&](const LatticeStep& step) {
    return step.value() == steps[0].value() && scene.box.size() <= step.value();
  });
  std::vector<Point> offsets;
  for (std::size_t m = 0; m < steps.size(); ++m)
    offsets.push_back(steps[m].offset(is_small ? scene.box : scene.boxes[m]));
  return offsets;
}

// How far the vertices of meshes that lie far away were moved.
class Losses {
 public:
  void add(const FileMesh& mesh, double size, double loss) {
    if (loss > kFloatLoss * size) largest_ = std::max(largest_, loss);
    if (!(size > 0) || !(loss > kWarnedLoss * size)) return;
    ++count_;
    if (count_ > 1 && loss / size <= worst_ / size_) return;
    name_ = node_name(mesh.name);
    worst_ = loss;
    size_ = size;
  }

  std::vector<Warning> warnings() const {
    if (count_ == 0 && largest_ > 0) {
      return {{.kind = "rounded",
               .message = fmt::format("vertices far from the origin were moved by up to {:.3g}, "
                                      "so that float32 and an offset hold them",
                                      largest_),
               .is_note = true}};
    }
    if (count_ == 0) return {};
    const std::string more = count_ == 1 ? "" : fmt::format("; so are {} more meshes", count_ - 1);
    return {{"precision", count_, fmt::format("mesh '{}'", name_),
             fmt::format("vertices are kept as float32, far from the origin: those of mesh '{}', "
                         "which is {:.3g} units in size, are moved by up to {:.3g}{}",
                         name_, size_, worst_, more)}};
  }

 private:
  std::uint64_t count_ = 0;  // meshes that lose more than kWarnedLoss
  std::string name_;         // the one that loses most of its size
  double worst_ = 0, size_ = 1;
  double largest_ = 0;  // more than a float loses near its mesh's middle
};

// Near the origin, floats are what all scenes have.
bool is_near(const VertexBox& box, const LatticeStep& step) {
  const Point reach = box.reach();
  return std::isfinite(step.value()) && std::all_of(reach.begin(), reach.end(), [&](double r) {
           return r < LatticeStep::kFarSteps * step.value();
         });
}

std::vector<Warning> apply(std::vector<FileMesh>& meshes, const Scene& scene,
                           const std::vector<LatticeStep>& steps,
                           const std::vector<Point>& offsets) {
  Losses losses;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const double loss = round_and_subtract(meshes[m], steps[m], offsets[m]);
    if (offsets[m] != Point{} || !is_near(scene.boxes[m], steps[m]))
      losses.add(meshes[m], scene.boxes[m].size(), loss);
  }
  return losses.warnings();
}

Warning own_steps_warning(std::size_t own_steps) {
  return {"several_lattices", own_steps, "",
          "its meshes differ so much in size, so far from the origin, that their vertices are "
          "rounded differently: rays may slip between two that share an edge"};
}

}  // namespace

Rebased rebase(std::vector<FileMesh>& meshes, std::vector<ImportedNode>& nodes) {
  const Scene scene(meshes);
  Rebased out;
  out.offsets.assign(meshes.size(), exact_offset(scene.box));
  if (are_floats(meshes) && is_exact(meshes, out.offsets)) {
    if (auto with_offsets = moved(nodes, out.offsets)) {
      nodes = *std::move(with_offsets);
      subtract_exactly(meshes, out.offsets);
      return out;
    }
  } else {
    std::size_t own_steps = 0;
    const std::vector<LatticeStep> steps = choose_steps(scene, own_steps);
    out.offsets = choose_offsets(scene, steps);
    if (auto with_offsets = moved(nodes, out.offsets)) {
      nodes = *std::move(with_offsets);
      out.warnings = apply(meshes, scene, steps, out.offsets);
      if (own_steps > 0) out.warnings.push_back(own_steps_warning(own_steps));
      return out;
    }
  }
  out.offsets.assign(meshes.size(), Point{});
  const std::vector<LatticeStep> floats(meshes.size(), LatticeStep());
  out.warnings = apply(meshes, scene, floats, out.offsets);
  return out;
}

Result<Rebased> rebase_to(std::vector<Point> offsets, std::vector<FileMesh>& meshes,
                          std::vector<ImportedNode>& nodes) {
  auto with_offsets = moved(nodes, offsets);
  if (!with_offsets)
    return import_error("the transform of a node cannot hold the offset of another file");
  nodes = *std::move(with_offsets);
  Rebased out{std::move(offsets), {}};
  if (is_exact(meshes, out.offsets)) {
    subtract_exactly(meshes, out.offsets);
    return out;
  }
  const Scene scene(meshes);
  std::size_t own_steps = 0;
  out.warnings = apply(meshes, scene, choose_steps(scene, own_steps), out.offsets);
  for (const Warning& warning : out.warnings) {
    if (!warning.is_note)
      return import_error("lies too far from the offset of another file: " + warning.message);
  }
  return out;
}

}  // namespace sightline::client::importer
