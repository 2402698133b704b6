// Composes transforms twice, in float32 as Assimp does, and in double.
#include "client/importer/collada_transforms.h"

#include <assimp/types.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <vector>

#include "client/importer/collada_numbers.h"
#include "client/importer/xml_tags.h"

namespace sightline::client::importer {
namespace {

using Numbers = std::array<double, 16>;

// The matrix of an element in a node. The identity: it is no transform, or one that moves nothing.
template <class Real>
aiMatrix4x4t<Real> matrix_of(std::string_view name, const Numbers& numbers) {
  std::array<Real, 16> n{};
  std::transform(numbers.begin(), numbers.end(), n.begin(),
                 [](double x) { return static_cast<Real>(x); });
  aiMatrix4x4t<Real> out;
  if (name == "translate") {
    aiMatrix4x4t<Real>::Translation({n[0], n[1], n[2]}, out);
  } else if (name == "scale") {
    aiMatrix4x4t<Real>::Scaling({n[0], n[1], n[2]}, out);
  } else if (name == "rotate") {
    constexpr Real kDegree = std::numbers::pi_v<Real> / Real{180};
    aiMatrix4x4t<Real>::Rotation(n[3] * kDegree, {n[0], n[1], n[2]}, out);
  } else if (name == "matrix") {
    out = {n[0], n[1], n[2],  n[3],  n[4],  n[5],  n[6],  n[7],
           n[8], n[9], n[10], n[11], n[12], n[13], n[14], n[15]};
  } else if (name == "lookat") {
    aiMatrix4x4t<Real>::Translation({n[0], n[1], n[2]}, out);  // its distance is what is rounded
  }
  return out;
}

struct Node {
  std::string_view name;
  aiMatrix4x4t<double> exact;
  aiMatrix4x4t<float> rounded;
};

void add(Node& node, const XmlTag& tag) {
  Numbers numbers{};
  std::string_view rest = tag.text;
  for (double& number : numbers) {
    if (const auto value = collada_number(take_collada_word(rest))) number = *value;
  }
  node.exact *= matrix_of<double>(tag.name, numbers);
  node.rounded *= matrix_of<float>(tag.name, numbers);
}

double loss_of(const Node& node) {
  return std::hypot(node.exact.a4 - static_cast<double>(node.rounded.a4),
                    node.exact.b4 - static_cast<double>(node.rounded.b4),
                    node.exact.c4 - static_cast<double>(node.rounded.c4));
}

bool is_transform(std::string_view name) {
  return std::any_of(std::begin(kColladaTransforms), std::end(kColladaTransforms),
                     [&](const auto& transform) { return transform.first == name; });
}

}  // namespace

std::unordered_map<std::string_view, double> collada_losses(std::string_view text) {
  std::unordered_map<std::string_view, double> losses;
  std::vector<Node> open;
  XmlTags tags(text);
  while (const auto tag = tags.next()) {
    if (tag->name == "node" && tag->is_end && !open.empty()) {
      const double loss = loss_of(open.back());
      if (loss > 0) losses[open.back().name] = std::max(losses[open.back().name], loss);
      open.pop_back();
    } else if (tag->name == "node" && !tag->is_end && !tag->is_empty) {
      const std::string_view id = tag->attribute("id");
      open.push_back({id.empty() ? tag->attribute("sid") : id, {}, {}});
    } else if (!open.empty() && !tag->is_end && is_transform(tag->name)) {
      add(open.back(), *tag);
    }
  }
  return losses;
}

}  // namespace sightline::client::importer
