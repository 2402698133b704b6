// Parents first, without recursion, because files determine the depth.
#include "client/importer/gltf/nodes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "client/importer/affine.h"

namespace sightline::client::importer::gltf {
namespace {

constexpr double kAffine = 1e-4;  // what the last row of a matrix may be off

std::string name_of(const Item& node, std::uint64_t index) {
  const std::string name = node.text("name");
  return name.empty() ? fmt::format("nodes[{}]", index) : name;
}

// Children and parents of all nodes of the file.
struct Family {
  std::vector<std::vector<std::uint64_t>> children;
  std::vector<std::uint32_t> parent;

  explicit Family(const Document& document)
      : children(document.count("nodes")), parent(children.size(), kNone) {
    for (std::size_t i = 0; i < children.size(); ++i) {
      const Item node = document.at("nodes", i, "the file");
      children[i] = node.integers("children");
      for (const std::uint64_t child : children[i]) {
        document.at("nodes", child, node.where());
        if (parent[child] != kNone) {
          refuse("nodes[{}] has two parents, nodes[{}] and nodes[{}]", child, parent[child], i);
        }
        parent[child] = static_cast<std::uint32_t>(i);
      }
    }
  }
};

std::vector<std::uint64_t> roots_of(const Document& document, const Family& family,
                                    std::vector<Warning>& warnings) {
  std::vector<std::uint64_t> roots;
  const std::size_t scenes = document.count("scenes");
  if (scenes == 0) {
    if (document.root().has("scene"))
      document.at("scenes", document.root().integer("scene"), "scene");
    for (std::size_t i = 0; i < family.parent.size(); ++i) {
      if (family.parent[i] == kNone) roots.push_back(i);
    }
    warnings.push_back(
        {.kind = "no_scene",
         .message = fmt::format("it has no scenes, so that glTF does not say what is "
                                "shown; all of its {} nodes are read",
                                family.parent.size())});
    return roots;
  }
  const std::uint64_t chosen = document.root().integer("scene", 0);
  const Item scene = document.at("scenes", chosen, "scene");
  if (scenes > 1) {
    warnings.push_back({.kind = "other_scenes",
                        .count = scenes - 1,
                        .first = fmt::format("scenes[{}]", chosen == 0 ? 1 : 0),
                        .message = fmt::format("it has {} scenes; only scenes[{}] '{}' is read",
                                               scenes, chosen, scene.text("name"))});
  }
  roots = scene.integers("nodes");
  std::vector<bool> is_listed(family.parent.size());
  for (const std::uint64_t root : roots) {
    document.at("nodes", root, scene.where());
    if (family.parent[root] != kNone) {
      refuse("{} lists nodes[{}], which is a child of nodes[{}]", scene.where(), root,
             family.parent[root]);
    }
    if (is_listed[root]) refuse("{} lists nodes[{}] twice", scene.where(), root);
    is_listed[root] = true;
  }
  return roots;
}

// Each instance's place in the frame of the node.
std::vector<Transform> instances_of(const Item& extension, Accessors& accessors) {
  const auto attributes = extension.object("attributes");
  if (!attributes) refuse("{}: attributes is missing", extension.where());
  std::optional<std::uint64_t> count;
  for (const auto& [name, accessor] : attributes->named_integers()) {
    const std::uint64_t elements = accessors.count(accessor, extension.where());
    if (count && *count != elements)
      refuse("{}: its attributes have {} and {} elements", extension.where(), *count, elements);
    count = elements;
  }
  if (!count) refuse("{}: attributes is empty", extension.where());
  if (*count > kMostNodes)
    refuse("{}: it has {} instances, the limit is {}", extension.where(), *count, kMostNodes);
  std::vector<Point> translations(*count, Point{0, 0, 0});
  std::vector<Point> scales(translations.size(), Point{1, 1, 1});
  std::vector<std::array<double, 4>> rotations(translations.size(), {0, 0, 0, 1});
  const auto read = [&]<std::size_t kWidth>(const char* name,
                                            std::vector<std::array<double, kWidth>>& rows) {
    if (attributes->has(name))
      rows = accessors.rows<kWidth>(attributes->integer(name), attributes->where());
  };
  read("TRANSLATION", translations);
  read("ROTATION", rotations);
  read("SCALE", scales);
  std::vector<Transform> out;
  for (std::size_t i = 0; i < translations.size(); ++i) {
    out.push_back(compose(translations[i], rotation_of(rotations[i]), scales[i]));
  }
  return out;
}

class NodeReader {
 public:
  NodeReader(const Document& document, Accessors& accessors)
      : document_(document), accessors_(accessors), family_(document) {}

  Nodes read(std::vector<Warning>& warnings) {
    const std::vector<std::uint64_t> roots = roots_of(document_, family_, warnings);
    out_.from_gltf.assign(family_.parent.size(), kNone);
    std::uint32_t top = kNone;
    if (roots.size() != 1) {
      out_.nodes.push_back({"ROOT", kNone, kIdentity, {}});
      top = 0;
    }
    std::vector<Open> open;
    push(roots, top, true, open);
    while (!open.empty()) {
      const Open next = open.back();
      open.pop_back();
      add(next, open);
    }
    return std::move(out_);
  }

 private:
  struct Open {
    std::uint64_t gltf = 0;
    std::uint32_t parent = kNone;
    bool is_visible = true;
  };

  static void push(const std::vector<std::uint64_t>& list, std::uint32_t parent, bool is_visible,
                   std::vector<Open>& open) {
    for (std::size_t k = list.size(); k-- > 0;) open.push_back({list[k], parent, is_visible});
  }

  void add(const Open& from, std::vector<Open>& open) {
    const Item item = document_.at("nodes", from.gltf, "the file");
    const auto index = static_cast<std::uint32_t>(out_.nodes.size());
    const std::string name = name_of(item, from.gltf);
    out_.nodes.push_back({name, from.parent, local_transform(item).matrix, {}});
    out_.from_gltf[from.gltf] = index;
    const auto visibility = item.extension("KHR_node_visibility");
    const bool is_visible = from.is_visible && (!visibility || visibility->flag("visible", true));
    if (is_visible && item.has("mesh")) {
      const auto gltf = static_cast<std::uint32_t>(from.gltf);
      if (const auto instancing = item.extension("EXT_mesh_gpu_instancing")) {
        add_instances(item, *instancing, gltf, index);
      } else {
        out_.mesh_nodes.push_back({gltf, index, 1});
      }
    }
    push(family_.children[from.gltf], index, is_visible, open);
  }

  void add_instances(const Item& item, const Item& extension, std::uint32_t gltf,
                     std::uint32_t parent) {
    if (item.has("skin")) refuse("{} has a skin and EXT_mesh_gpu_instancing", item.where());
    const std::vector<Transform> instances = instances_of(extension, accessors_);
    instances_ += instances.size();
    if (instances_ > kMostNodes)
      refuse("it has {} instances or more, the limit is {}", instances_, kMostNodes);
    out_.mesh_nodes.push_back({gltf, static_cast<std::uint32_t>(out_.nodes.size()),
                               static_cast<std::uint32_t>(instances.size())});
    const std::string name = out_.nodes[parent].name;
    for (std::size_t i = 0; i < instances.size(); ++i)
      out_.nodes.push_back({fmt::format("{}#{}", name, i), parent, instances[i], {}});
  }

  const Document& document_;
  Accessors& accessors_;
  const Family family_;
  Nodes out_;
  std::uint64_t instances_ = 0;
};

}  // namespace

Quaternion rotation_of(const std::array<double, 4>& xyzw) {
  double greatest = 0;
  for (const double x : xyzw) greatest = std::max(greatest, std::abs(x));
  if (greatest == 0) return {1, 0, 0, 0};
  const auto [x, y, z, w] = xyzw;
  Quaternion out{w / greatest, x / greatest, y / greatest, z / greatest};
  double square = 0;
  for (const double part : out) square += part * part;
  for (double& part : out) part /= std::sqrt(square);
  return out;
}

Transform affine_of(const std::array<double, 16>& columns, const std::string& last_row) {
  const std::array<double, 16>& m = columns;
  if (std::abs(m[3]) + std::abs(m[7]) + std::abs(m[11]) + std::abs(m[15] - 1) > kAffine)
    refuse("{} is {} {} {} {}, must be 0 0 0 1", last_row, m[3], m[7], m[11], m[15]);
  Transform rows{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 4; ++c) rows[4 * r + c] = m[4 * c + r];
  }
  return rows;
}

LocalTransform local_transform(const Item& node) {
  LocalTransform out;
  if (const auto columns = node.numbers<16>("matrix")) {
    if (node.has("translation") || node.has("rotation") || node.has("scale"))
      refuse("{} has a matrix and also a translation, a rotation or a scale", node.where());
    out.has_matrix = true;
    out.matrix = affine_of(*columns, node.where() + ": the last row of its matrix");
    return out;
  }
  if (const auto translation = node.numbers<3>("translation")) out.translation = *translation;
  if (const auto rotation = node.numbers<4>("rotation")) out.rotation = rotation_of(*rotation);
  if (const auto scale = node.numbers<3>("scale")) out.scale = *scale;
  out.matrix = compose(out.translation, out.rotation, out.scale);
  return out;
}

Nodes read_nodes(const Document& document, Accessors& accessors, std::vector<Warning>& warnings) {
  return NodeReader(document, accessors).read(warnings);
}

}  // namespace sightline::client::importer::gltf
