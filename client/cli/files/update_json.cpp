// Checks every key: it must be known, of the right type and in range.
#include "client/cli/files/update_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "client/cli/flags.h"
#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

constexpr std::int64_t kAnyNode = std::numeric_limits<std::int64_t>::min();

const std::map<std::string, Mobility> kMobilities{
    {"static", Mobility::kStatic},        {"rigid", Mobility::kRigid},
    {"deforming", Mobility::kDeforming},  {"MOBILITY_STATIC", Mobility::kStatic},
    {"MOBILITY_RIGID", Mobility::kRigid}, {"MOBILITY_DEFORMING", Mobility::kDeforming}};

// Reads the keys of one object. Stores the first problem; values read after it do not matter.
class Fields {
 public:
  Fields(const Json& object, std::string name, std::initializer_list<const char*> known)
      : object_(object), name_(std::move(name)) {
    if (!object.is_object()) {
      complain("", "is no object");
      return;
    }
    for (const auto& [key, value] : object.items()) {
      if (std::find(known.begin(), known.end(), key) == known.end()) complain(key, "is not known");
    }
  }

  template <class Int>
  Int integer(const char* key, Int lowest, std::optional<Int> otherwise = {}) {
    const Json* value = find(key, !otherwise);
    if (value == nullptr) return otherwise.value_or(Int{});
    const auto number = as_integer<Int>(*value, lowest);
    if (!number) {
      complain(key, fmt::format("is not a whole number from {} to {}", lowest,
                                std::numeric_limits<Int>::max()));
    }
    return number.value_or(Int{});
  }

  bool flag(const char* key) {
    const Json* value = find(key, false);
    if (value != nullptr && !value->is_boolean()) complain(key, "is not true or false");
    return value != nullptr && value->is_boolean() && value->get<bool>();
  }

  std::string text(const char* key) {
    const Json* value = find(key, false);
    if (value != nullptr && !value->is_string()) complain(key, "is no string");
    return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
  }

  Mobility mobility(const char* key) {
    const std::string word = text(key);
    const auto found = kMobilities.find(word);
    if (!word.empty() && found == kMobilities.end())
      complain(key, fmt::format("is '{}', not static, rigid or deforming", word));
    return found == kMobilities.end() ? Mobility::kStatic : found->second;
  }

  // Reads an object of strings.
  std::vector<Label> labels(const char* key) {
    std::vector<Label> out;
    const Json* value = find(key, false);
    if (value == nullptr) return out;
    if (!value->is_object()) {
      complain(key, "is no object");
      return out;
    }
    out.reserve(value->size());
    for (const auto& [name, text] : value->items()) {
      if (!text.is_string()) complain(key, fmt::format("has at '{}' what is no string", name));
      out.push_back({name, text.is_string() ? text.get<std::string>() : std::string()});
    }
    return out;
  }

  NodeRefs nodes(const char* key) {
    NodeRefs out;
    for (const Json& each : list(key)) {
      const auto node = as_integer<std::int64_t>(each, kAnyNode);
      if (!node) complain(key, "holds what is no node");
      out.push_back(node.value_or(0));
    }
    return out;
  }

  // Reads [12 or 16 numbers], or the form of the message, {"matrix": [12 or 16 numbers]}.
  Transform transform(const char* key) {
    const Json* value = find(key, false);
    if (value == nullptr) return kIdentity;
    if (value->is_object() && value->size() == 1 && value->contains("matrix"))
      value = &(*value)["matrix"];
    return matrix(*value, key);
  }

  std::vector<Transform> matrices(const char* key) {
    std::vector<Transform> out;
    for (const Json& each : list(key))
      out.push_back(matrix(each, fmt::format("{} row {}", key, out.size())));
    return out;
  }

  template <class Row>
  std::vector<Row> rows(const char* key) {
    std::vector<Row> out;
    for (const Json& each : list(key)) {
      if (!read_row(each, out.emplace_back())) {
        complain(key, fmt::format("row {} is not {} numbers", out.size() - 1, Row().size()));
      }
    }
    return out;
  }

  Result<Update> finish(Update update) const {
    if (problem_) return local_error(*problem_);
    return update;
  }

 private:
  Transform matrix(const Json& value, const std::string& key) {
    Transform out{};
    if (read_row(value, out)) return out;
    std::array<double, 16> whole{};
    if (!read_row(value, whole)) {
      complain(key, "is not 12 or 16 numbers");
      return out;
    }
    const auto affine = to_transform(whole);
    if (!affine) complain(key, "is wrong: " + affine.error().message);
    return affine ? *affine : out;
  }

  template <class Int>
  static std::optional<Int> as_integer(const Json& value, Int lowest) {
    if (value.is_number_unsigned()) {
      const auto number = value.get<std::uint64_t>();
      if (number > static_cast<std::uint64_t>(std::numeric_limits<Int>::max())) return {};
      return static_cast<Int>(number);
    }
    if (!value.is_number_integer()) return {};
    const auto number = value.get<std::int64_t>();
    if (!std::in_range<Int>(number) || std::cmp_less(number, lowest)) return {};
    return static_cast<Int>(number);
  }

  template <class Row>
  static bool read_row(const Json& values, Row& row) {
    if (!values.is_array() || values.size() != row.size()) return false;
    for (std::size_t k = 0; k < row.size(); ++k) {
      if (!values[k].is_number()) return false;
      row[k] = values[k].get<typename Row::value_type>();
    }
    return true;
  }

  const Json* find(const char* key, bool needed) {
    const auto found = object_.is_object() ? object_.find(key) : object_.end();
    if (found != object_.end()) return &*found;
    if (needed && object_.is_object()) complain(key, "is missing");
    return nullptr;
  }

  const Json& list(const char* key) {
    static const Json kEmpty = Json::array();
    const Json* value = find(key, true);
    if (value == nullptr) return kEmpty;
    if (!value->is_array()) complain(key, "is no list");
    return value->is_array() ? *value : kEmpty;
  }

  void complain(const std::string& key, const std::string& what) {
    if (problem_) return;
    problem_ =
        key.empty() ? fmt::format("{} {}", name_, what) : fmt::format("{}.{} {}", name_, key, what);
  }

  const Json& object_;
  std::string name_;
  std::optional<std::string> problem_;
};

Result<Update> put_node(const Json& object) {
  Fields fields(
      object, "put_node",
      {"node", "parent", "name", "transform", "mesh_digest", "mobility", "mask", "labels"});
  PutNode put;
  put.node = fields.integer<std::int64_t>("node", kAnyNode);
  put.parent = fields.integer<std::int64_t>("parent", kAnyNode, 0);
  put.name = fields.text("name");
  put.parent_from_local = fields.transform("transform");
  put.mesh_digest = fields.text("mesh_digest");
  put.mobility = fields.mobility("mobility");
  put.mask = fields.integer<std::uint32_t>("mask", 0, 0xffffffff);
  put.labels = fields.labels("labels");
  return fields.finish(std::move(put));
}

Result<Update> set_transforms(const Json& object) {
  Fields fields(object, "set_transforms", {"nodes", "matrices"});
  SetTransforms set{fields.nodes("nodes"), fields.matrices("matrices")};
  if (set.nodes.size() != set.parent_from_local.size()) {
    return local_error(fmt::format("set_transforms has {} nodes but {} matrices", set.nodes.size(),
                                   set.parent_from_local.size()));
  }
  return fields.finish(std::move(set));
}

Result<Update> delete_node(const Json& object) {
  Fields fields(object, "delete_node", {"node", "subtree"});
  const DeleteNode deleted{fields.integer<std::int64_t>("node", kAnyNode), fields.flag("subtree")};
  return fields.finish(deleted);
}

Result<Update> patch_vertices(const Json& object) {
  Fields fields(object, "patch_vertices", {"nodes", "first", "positions"});
  PatchVertices patch{fields.nodes("nodes"), fields.integer<std::uint32_t>("first", 0, 0),
                      fields.rows<Vertex>("positions")};
  return fields.finish(std::move(patch));
}

std::vector<std::int64_t> numbers_of(const NodeRefs& nodes) { return {nodes.begin(), nodes.end()}; }

struct ToJson {
  bool positions;

  Json operator()(const PutNode& put) const {
    Json node{
        {"node", std::int64_t{put.node}}, {"parent", std::int64_t{put.parent}}, {"name", put.name}};
    if (put.parent_from_local != kIdentity) node["transform"] = put.parent_from_local;
    if (!put.mesh_digest.empty()) node["mesh_digest"] = put.mesh_digest;
    node["mobility"] = name_of(put.mobility);
    if (put.mask != 0xffffffff) node["mask"] = put.mask;
    if (!put.labels.empty()) node["labels"] = json_of(put.labels);
    return {{"put_node", node}};
  }
  Json operator()(const SetTransforms& set) const {
    return {{"set_transforms",
             {{"nodes", numbers_of(set.nodes)}, {"matrices", set.parent_from_local}}}};
  }
  Json operator()(const DeleteNode& deleted) const {
    return {{"delete_node", {{"node", std::int64_t{deleted.node}}, {"subtree", deleted.subtree}}}};
  }
  Json operator()(const PatchVertices& patch) const {
    Json vertices{{"nodes", numbers_of(patch.nodes)}, {"first", patch.first}};
    if (positions) {
      vertices["positions"] = patch.positions;
    } else {
      vertices["vertices"] = patch.positions.size();
    }
    return {{"patch_vertices", vertices}};
  }
};

}  // namespace

const char* name_of(Mobility mobility) {
  if (mobility == Mobility::kRigid) return "rigid";
  return mobility == Mobility::kDeforming ? "deforming" : "static";
}

Result<Update> parse_update(std::string_view text) {
  Json line;
  try {
    line = Json::parse(text);
  } catch (const Json::parse_error& e) {
    return local_error(fmt::format("is no JSON, from byte {} on", e.byte));
  }
  if (!line.is_object() || line.size() != 1) {
    return local_error(
        "is not one of put_node, set_transforms, delete_node, patch_vertices with its object");
  }
  const std::string& key = line.begin().key();
  const Json& object = line.begin().value();
  if (key == "put_node") return put_node(object);
  if (key == "set_transforms") return set_transforms(object);
  if (key == "delete_node") return delete_node(object);
  if (key == "patch_vertices") return patch_vertices(object);
  return local_error(
      fmt::format("{} is not one of put_node, set_transforms, delete_node, patch_vertices", key));
}

Json json_of(const std::vector<Label>& labels) {
  Json object = Json::object();
  for (const Label& label : labels) object[label.key] = label.value;
  return object;
}

Json json_of(const Update& update, bool positions) { return std::visit(ToJson{positions}, update); }

}  // namespace sightline::client::cli::files
