// Counts meshes and items: each item of a representation is a mesh, and each mapped item is a node
// with a mesh for each item of what is mapped.
#include "client/importer/ifc_products.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace sightline::client::importer {
namespace {

constexpr std::size_t kIdLength = 22;

// Items without a surface. Rays meet nothing in them, whether Assimp reads them or not.
constexpr std::string_view kNoSurface[] = {"IFCPOLYLINE",
                                           "IFCTRIMMEDCURVE",
                                           "IFCCOMPOSITECURVE",
                                           "IFC2DCOMPOSITECURVE",
                                           "IFCCIRCLE",
                                           "IFCELLIPSE",
                                           "IFCLINE",
                                           "IFCBEZIERCURVE",
                                           "IFCRATIONALBEZIERCURVE",
                                           "IFCOFFSETCURVE2D",
                                           "IFCOFFSETCURVE3D",
                                           "IFCGEOMETRICCURVESET",
                                           "IFCCARTESIANPOINT",
                                           "IFCBOUNDINGBOX",
                                           "IFCTEXTLITERAL",
                                           "IFCTEXTLITERALWITHEXTENT"};

// Representations of these names are not the body of a product.
constexpr std::string_view kNoBody[] = {"'Axis'",      "'FootPrint'", "'Box'",
                                        "'CoG'",       "'Profile'",   "'Annotation'",
                                        "'Reference'", "'Clearance'", "'Lighting'"};

// Products whose body is not solid: what they stand for is empty.
constexpr std::string_view kNoMatter[] = {
    "IFCOPENINGELEMENT", "IFCEDGEFEATURE",    "IFCCHAMFEREDGEFEATURE", "IFCROUNDEDEDGEFEATURE",
    "IFCSPACE",          "IFCVIRTUALELEMENT", "IFCANNOTATION"};

template <class Words>
bool is_among(const Words& words, std::string_view word) {
  return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

bool has_surface(const Statements& statements, const Statement& item) {
  if (item.type != "IFCGEOMETRICSET") return !is_among(kNoSurface, item.type);
  return !statements.each_of(argument(item, 0), [](const Statement& element) {
    return is_among(kNoSurface, element.type);
  });
}

// How many meshes the items of the representation should be.
std::size_t count_items(const Statements& statements, const Statement& representation,
                        bool is_mapped = false) {
  std::size_t count = 0;
  std::set<const Statement*> items;
  statements.each_of(argument(representation, 3), [&](const Statement& item) {
    if (item.type == "IFCMAPPEDITEM" && !is_mapped) {
      const Statement* const map = statements.find(argument(item, 0));
      const Statement* const mapped = map ? statements.find(argument(*map, 1)) : nullptr;
      count += mapped ? count_items(statements, *mapped, true) : 1;
    } else if (has_surface(statements, item)) {
      items.insert(&item);
    }
    return true;
  });
  return count + items.size();
}

struct Body {
  std::vector<std::size_t> counts;  // how many meshes each representation that is a body has
  bool comes_late = false;          // another representation with surfaces stands before it
};

Body body_of(const Statements& statements, const Statement& shape) {
  Body body;
  bool has_other = false;
  statements.each_of(argument(shape, 2), [&](const Statement& representation) {
    const std::size_t count = count_items(statements, representation);
    if (count == 0) return true;
    if (is_among(kNoBody, argument(representation, 1))) {
      has_other = true;
    } else {
      body.comes_late = body.comes_late || (body.counts.empty() && has_other);
      body.counts.push_back(count);
    }
    return true;
  });
  return body;
}

// The meshes of products, by their GlobalIds. A product may be in several nodes.
std::unordered_map<std::string_view, std::vector<std::size_t>> count_meshes(
    const FileScene& scene) {
  std::vector<std::size_t> counts;
  for (const FileNode& node : scene.nodes) {
    counts.push_back(node.meshes.size());
    if (node.name == "IfcMappedItem" && node.parent != kNone)
      counts[node.parent] += node.meshes.size();
  }
  std::unordered_map<std::string_view, std::vector<std::size_t>> out;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const std::string_view id = global_id_of(scene.nodes[i]);
    if (!id.empty()) out[id].push_back(counts[i]);
  }
  return out;
}

// How many meshes the product lacks in the node that has most of them. Some files use a GlobalId
// twice.
std::size_t count_lacking(const Body& body, const std::vector<std::size_t>& meshes) {
  const std::size_t wanted = *std::max_element(body.counts.begin(), body.counts.end());
  std::size_t lacking = wanted;
  for (const std::size_t count : meshes) {
    if (std::find(body.counts.begin(), body.counts.end(), count) != body.counts.end()) return 0;
    if (count > 0) lacking = std::min(lacking, wanted > count ? wanted - count : 1);
  }
  return lacking;
}

bool is_hollow(const Statements& statements, const Statement& statement) {
  if (statement.type == "IFCCIRCLEHOLLOWPROFILEDEF" ||
      statement.type == "IFCRECTANGLEHOLLOWPROFILEDEF" ||
      statement.type == "IFCFACETEDBREPWITHVOIDS")
    return true;
  if (statement.type == "IFCSWEPTDISKSOLID") return argument(statement, 2) != "$";
  if (statement.type != "IFCREVOLVEDAREASOLID") return false;
  const Statement* const area = statements.find(argument(statement, 0));
  return area != nullptr && area->type == "IFCARBITRARYPROFILEDEFWITHVOIDS";
}

bool is_turned(const Statements&, const Statement& statement) {
  return statement.type == "IFCFACEOUTERBOUND" && argument(statement, 1) == ".F.";
}

bool has_round_corners(const Statements&, const Statement& statement) {
  return statement.type == "IFCROUNDEDRECTANGLEPROFILEDEF";
}

bool is_shifted(const Statements&, const Statement& statement) {
  return statement.type == "IFCISHAPEPROFILEDEF" ||
         statement.type == "IFCASYMMETRICISHAPEPROFILEDEF";
}

bool is_space(const Statements& statements, const Statement& statement) {
  return statement.type == "IFCSPACE" && statements.find(argument(statement, 6)) != nullptr;
}

struct Change {
  bool (*is_changed)(const Statements& statements, const Statement& statement);
  const char *kind, *what;
  bool is_note = false;
};

constexpr Change kChanges[] = {
    {is_hollow, "filled", "of its shapes are hollow, and Assimp fills them"},
    {is_turned, "faces_turned",
     "of its faces run against their loops, and Assimp does not turn them"},
    {has_round_corners, "corners_sharp",
     "of its profiles have round corners, and Assimp makes them sharp"},
    {is_shifted, "profiles_moved",
     "of its profiles have the shape of an I, and Assimp puts their corner where their middle is"},
    {is_space, "spaces_left_out", "of its products are spaces, which are left out", true}};

// Counts statements, and says which is the first.
class Counted {
 public:
  void add(std::uint64_t number, std::size_t count = 1) {
    if (count > 0) first_ = count_ == 0 ? number : std::min(first_, number);
    count_ += count;
  }

  void warn(FileScene& scene, const char* kind, const char* what, bool is_note = false) const {
    if (count_ == 0) return;
    scene.warnings.push_back(
        {.kind = kind,
         .count = count_,
         .first = fmt::format("#{}", first_),
         .message = fmt::format("{} {}; the first is #{}", count_, what, first_),
         .is_note = is_note});
  }

 private:
  std::uint64_t count_ = 0, first_ = 0;
};

}  // namespace

std::string_view global_id_of(const FileNode& node) {
  const std::string_view name = node.name;
  const bool has_id = name.size() > kIdLength && name[name.size() - kIdLength - 1] == '_';
  return has_id ? name.substr(name.size() - kIdLength) : std::string_view();
}

void check_products(const Statements& statements, FileScene& scene) {
  const auto meshes = count_meshes(scene);
  Counted lacking, late;
  for (const auto& [number, statement] : statements.all()) {
    const Statement* const shape = statements.find(argument(statement, 6));
    if (shape == nullptr || shape->type != "IFCPRODUCTDEFINITIONSHAPE") continue;
    if (is_among(kNoMatter, statement.type)) continue;
    const Body body = body_of(statements, *shape);
    if (body.counts.empty()) continue;
    const std::string_view id = argument(statement, 0);
    const auto found = meshes.find(id.substr(std::min<std::size_t>(id.size(), 1), kIdLength));
    const bool is_there = found != meshes.end();
    lacking.add(number, count_lacking(body, is_there ? found->second : std::vector<std::size_t>()));
    late.add(number, body.comes_late ? 1 : 0);
  }
  lacking.warn(
      scene, "parts_left_out",
      "of the parts of its products have no surface here, as Assimp does not read their types, or "
      "finds no way to them from the project");
  late.warn(scene, "no_body",
            "of its products have another representation before their body, and Assimp takes it");
  for (const Change& change : kChanges) {
    Counted changed;
    for (const auto& [number, statement] : statements.all()) {
      if (change.is_changed(statements, statement)) changed.add(number);
    }
    changed.warn(scene, change.kind, change.what, change.is_note);
  }
}

}  // namespace sightline::client::importer
