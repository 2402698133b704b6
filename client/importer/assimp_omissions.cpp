// Looks for tags in Collada's text.
#include "client/importer/assimp_omissions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "client/importer/node_name.h"
#include "client/importer/xml_tags.h"

namespace sightline::client::importer {
namespace {

// The contents of the first array of each source, by the source's id.
std::unordered_map<std::string_view, std::string_view> arrays_of(std::string_view text) {
  std::unordered_map<std::string_view, std::string_view> out;
  std::string_view source;
  XmlTags tags(text);
  while (const auto tag = tags.next()) {
    if (tag->is_end) continue;
    if (tag->name == "source") source = tag->attribute("id");
    if (tag->name.ends_with("_array")) out.emplace(source, tag->text);
  }
  return out;
}

// The words or numbers, each once, in the arrays that inputs with this semantic name.
std::set<std::string> inputs(std::string_view text, std::string_view semantic) {
  std::set<std::string> out;
  std::unordered_map<std::string_view, std::string_view> arrays = arrays_of(text);
  XmlTags tags(text);
  while (const auto tag = tags.next()) {
    if (tag->name != "input" || tag->attribute("semantic") != semantic) continue;
    const std::string_view source = tag->attribute("source");
    if (!source.starts_with('#')) continue;
    const auto array = arrays.find(source.substr(1));
    if (array == arrays.end()) continue;
    std::istringstream words{std::string(array->second)};
    for (std::string word; words >> word;) out.insert(std::move(word));
    arrays.erase(array);  // Its words are known.
  }
  return out;
}

struct Weights {
  bool has_zero = false, has_one = false;  // among those that the file lists
};

Weights weights_of(std::string_view text) {
  if (text.starts_with("PK")) return {true, true};  // packed; it may hold any
  Weights out;
  for (const std::string& word : inputs(text, "MORPH_WEIGHT")) {
    const double weight = std::strtod(word.c_str(), nullptr);
    out.has_zero = out.has_zero || weight == 0;
    out.has_one = out.has_one || weight == 1;
  }
  return out;
}

// A weight that may be 0 or 1, or anything, is taken as 0.
void correct_weights(bool is_fbx, std::string_view bytes, FileScene& scene) {
  const Weights listed = is_fbx ? Weights{true, true} : weights_of(bytes);
  if (listed.has_one && !listed.has_zero) return;
  std::uint64_t unknown = 0;
  std::string first;
  for (FileMesh& mesh : scene.meshes) {
    for (double& weight : mesh.weights) {
      if (weight != 1 && !is_fbx) continue;
      weight = 0;
      if (listed.has_one && unknown++ == 0) first = node_name(mesh.name);
    }
  }
  if (unknown == 0) return;
  scene.warnings.push_back(
      {.kind = "weights_unknown",
       .count = unknown,
       .first = first,
       .message =
           fmt::format("Assimp does not say what weights the shapes of its meshes have, those "
                       "of mesh '{}' for example; {} are taken as 0",
                       first, unknown)});
}

void warn_of_interpolations(std::string_view text, FileScene& scene) {
  if (scene.animations.empty()) return;
  std::set<std::string> names = inputs(text, "INTERPOLATION");
  names.erase("LINEAR");
  if (names.empty()) return;
  scene.warnings.push_back(
      {.kind = "interpolation",
       .count = names.size(),
       .first = *names.begin(),
       .message = fmt::format("its animations have the interpolation {}; they are played linearly",
                              fmt::join(names, ", "))});
}

// Counts elements of one kind, and says which is the first.
struct Unread {
  const char *kind, *what;
  std::uint64_t count = 0;
  std::string first{};

  void add(const XmlTag& tag) {
    if (count++ == 0) first = fmt::format("<{}>", node_name(std::string(tag.name)));
  }
};

bool is_part_of_mesh(std::string_view name) {
  constexpr std::string_view kParts[] = {"source",     "vertices",  "triangles", "polylist",
                                         "polygons",   "tristrips", "trifans",   "lines",
                                         "linestrips", "extra"};
  return std::find(std::begin(kParts), std::end(kParts), name) != std::end(kParts);
}

void warn_of_unread_elements(std::string_view text, FileScene& scene) {
  Unread shapes{"shapes_left_out", "of its elements hold surfaces that Assimp does not read"};
  Unread frames{"frame_of_part",
                "of its elements state the unit or the axes of a part, which Assimp does not read"};
  std::vector<std::string_view> open;
  XmlTags tags(text);
  while (const auto tag = tags.next()) {
    if (tag->is_end) {
      if (!open.empty()) open.pop_back();
      continue;
    }
    const std::string_view parent = open.empty() ? std::string_view() : open.back();
    if ((parent == "geometry" && (tag->name == "brep" || tag->name == "convex_mesh")) ||
        (parent == "mesh" && !is_part_of_mesh(tag->name)))
      shapes.add(*tag);
    if (parent == "asset" && open.size() > 2 && (tag->name == "unit" || tag->name == "up_axis"))
      frames.add(*tag);
    if (!tag->is_empty) open.push_back(tag->name);
  }
  for (const Unread& unread : {shapes, frames}) {
    if (unread.count == 0) continue;
    scene.warnings.push_back({.kind = unread.kind,
                              .count = unread.count,
                              .first = unread.first,
                              .message = fmt::format("{} {}; the first is {}", unread.count,
                                                     unread.what, unread.first)});
  }
}

}  // namespace

void correct_omissions(std::string_view importer_name, std::string_view bytes, FileScene& scene) {
  const bool is_fbx = importer_name.find("FBX") != std::string_view::npos;
  const bool is_collada = importer_name.find("Collada") != std::string_view::npos;
  if (is_fbx || is_collada) correct_weights(is_fbx, bytes, scene);
  if (!is_collada) return;
  warn_of_interpolations(bytes, scene);
  warn_of_unread_elements(bytes, scene);
}

}  // namespace sightline::client::importer
