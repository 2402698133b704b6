// Reads attributes from accessors, or from what Draco decoded.
#include "client/importer/gltf/primitive.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace sightline::client::importer::gltf {
namespace {

constexpr double kMostWeight = 1e100;  // sums of these are finite

Mode mode_of(const Item& item) {
  const std::uint64_t mode = item.integer("mode", static_cast<std::uint64_t>(Mode::kTriangles));
  if (mode > static_cast<std::uint64_t>(Mode::kTriangleFan))
    refuse("{}: mode is {}, must be 0 to 6", item.where(), mode);
  return static_cast<Mode>(mode);
}

bool is_needed(const std::string& attribute) {
  return attribute == "POSITION" || attribute.starts_with("JOINTS_") ||
         attribute.starts_with("WEIGHTS_");
}

void add_influences(const std::vector<std::vector<std::array<double, 4>>>& joints,
                    const std::vector<std::vector<std::array<double, 4>>>& weights, std::size_t v,
                    Skin& skin) {
  const std::size_t begin = skin.influences.size();
  double sum = 0;
  for (std::size_t set = 0; set < joints.size(); ++set) {
    for (std::size_t k = 0; k < 4; ++k) {
      const double weight = weights[set][v][k];
      if (weight == 0) continue;
      skin.influences.push_back({static_cast<std::uint32_t>(joints[set][v][k]), weight});
      sum += weight;
    }
  }
  for (std::size_t i = begin; i < skin.influences.size(); ++i) skin.influences[i].weight /= sum;
  skin.first.push_back(static_cast<std::uint32_t>(skin.influences.size()));
}

}  // namespace

Primitive::Primitive(const Item& item, const Document& document, Buffers& buffers,
                     Accessors& accessors)
    : item_(item), accessors_(accessors), mode_(mode_of(item)) {
  if (const auto attributes = item.object("attributes")) attributes_ = attributes->named_integers();
  if (const auto extension = item.extension("KHR_draco_mesh_compression"))
    decompress(*extension, document, buffers);
}

std::optional<std::uint64_t> Primitive::find(const std::string& attribute) const {
  for (const auto& [name, accessor] : attributes_) {
    if (name == attribute) return accessor;
  }
  return {};
}

// Draco has triangles only, whatever the mode says how they were stored.
void Primitive::decompress(const Item& extension, const Document& document, Buffers& buffers) {
  if (mode_ != Mode::kTriangles && mode_ != Mode::kTriangleStrip) {
    refuse("{}: mode is {}, must be 4 or 5 with KHR_draco_mesh_compression", item_.where(),
           static_cast<unsigned>(mode_));
  }
  mode_ = Mode::kTriangles;
  const Buffers::View view = buffers.view(extension.integer("bufferView"), extension.where());
  std::vector<DracoRequest> requests;
  const auto attributes = extension.object("attributes");
  if (!attributes) refuse("{}: attributes is missing", extension.where());
  for (const auto& [name, id] : attributes->named_integers()) {
    const auto accessor = find(name);
    if (!accessor) refuse("{}: {} is no attribute of the primitive", extension.where(), name);
    if (!is_needed(name)) continue;
    const Item item = document.at("accessors", *accessor, item_.where());
    requests.push_back({name, id, item.flag("normalized", false)});
  }
  draco_ = decode_draco(view.bytes, requests, item_.where());
}

template <std::size_t kWidth>
std::vector<std::array<double, kWidth>> Primitive::rows(const std::string& attribute) {
  if (draco_) {
    const auto decoded = draco_->attributes.find(attribute);
    if (decoded != draco_->attributes.end()) {
      const DracoAttribute& source = decoded->second;
      if (source.width != kWidth) {
        refuse("{}: {} has {} components, must have {}", item_.where(), attribute, source.width,
               kWidth);
      }
      std::vector<std::array<double, kWidth>> out(source.values.size() / kWidth);
      for (std::size_t i = 0; i < out.size(); ++i)
        std::copy_n(source.values.data() + i * kWidth, kWidth, out[i].data());
      return out;
    }
  }
  return accessors_.rows<kWidth>(*find(attribute), item_.where() + "." + attribute);
}

std::vector<Point> Primitive::vertices() { return rows<3>("POSITION"); }

std::vector<std::uint32_t> Primitive::indices(std::size_t vertices) {
  Accessors::Indices indices{{}, std::numeric_limits<std::uint32_t>::max()};
  if (draco_) {
    indices.values = std::move(draco_->corners);
  } else if (item_.has("indices")) {
    indices = accessors_.indices(item_.integer("indices"), item_.where() + ".indices");
  } else {
    indices.values.resize(vertices);
    std::iota(indices.values.begin(), indices.values.end(), 0U);
  }
  for (std::size_t i = 0; i < indices.values.size(); ++i) {
    const std::uint32_t vertex = indices.values[i];
    if (vertex >= vertices)
      refuse("{}: index {} names vertex {}, but there are {}", item_.where(), i, vertex, vertices);
    if (vertex == indices.greatest) {
      refuse("{}: index {} is {}, the greatest one of its type, which glTF reserves", item_.where(),
             i, vertex);
    }
  }
  return std::move(indices.values);
}

Shapes Primitive::shapes(std::size_t vertices) {
  Shapes shapes;
  for (const Item& target : item_.objects("targets")) {
    auto& shape = shapes.emplace_back(vertices);
    if (!target.has("POSITION")) continue;
    const auto offsets = accessors_.rows<3>(target.integer("POSITION"), target.where());
    if (offsets.size() != vertices) {
      refuse("{}: POSITION has {} elements, but there are {} vertices", target.where(),
             offsets.size(), vertices);
    }
    for (std::size_t v = 0; v < vertices; ++v) {
      for (std::size_t k = 0; k < 3; ++k) shape[v][k] = static_cast<float>(offsets[v][k]);
    }
  }
  return shapes;
}

std::vector<std::array<double, 4>> Primitive::influences(const std::string& attribute,
                                                         std::size_t vertices) {
  if (!find(attribute)) refuse("{} has no {}", item_.where(), attribute);
  auto out = rows<4>(attribute);
  if (out.size() != vertices) {
    refuse("{}: {} has {} elements, but there are {} vertices", item_.where(), attribute,
           out.size(), vertices);
  }
  return out;
}

Skin Primitive::skin(std::vector<Skin::Bone> bones, std::size_t vertices) {
  std::vector<std::vector<std::array<double, 4>>> joints, weights;
  for (std::size_t set = 0; find(fmt::format("JOINTS_{}", set)); ++set) {
    joints.push_back(influences(fmt::format("JOINTS_{}", set), vertices));
    weights.push_back(influences(fmt::format("WEIGHTS_{}", set), vertices));
  }
  Skin skin;
  skin.first.push_back(0);
  for (std::size_t v = 0; v < vertices; ++v) {
    for (std::size_t set = 0; set < joints.size(); ++set) {
      for (std::size_t k = 0; k < 4; ++k) {
        const double weight = weights[set][v][k], joint = joints[set][v][k];
        if (!(weight >= 0 && weight < kMostWeight))
          refuse("{}: vertex {} has the weight {}", item_.where(), v, weight);
        const bool is_joint =
            joint >= 0 && joint < static_cast<double>(bones.size()) && joint == std::floor(joint);
        if (weight > 0 && !is_joint) {
          refuse("{}: vertex {} names joint {}, but the skin has {}", item_.where(), v, joint,
                 bones.size());
        }
      }
    }
    add_influences(joints, weights, v, skin);
  }
  skin.bones = std::move(bones);
  return skin;
}

}  // namespace sightline::client::importer::gltf
