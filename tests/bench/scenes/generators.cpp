// Generators by name: their keys, defaults and ranges.
#include "tests/bench/scenes/generators.h"

#include <fmt/core.h>

#include <charconv>
#include <optional>

#include "tests/bench/scenes/generate_swarm.h"

namespace sightline::bench {
namespace {

constexpr std::uint64_t kMostTriangles = 100'000'000;
constexpr std::uint64_t kGeneratorSeed = 2006;
constexpr std::uint64_t kDefaultBoxes = 1000;

struct Key {
  std::string_view name;
  double fallback;  // Below `low`: the generator chooses
  double low, high;
  bool whole = true;
};

struct Values {
  std::map<std::string_view, double> numbers;
  std::string mesh;

  double number(std::string_view key) const { return numbers.at(key); }
  std::uint64_t count(std::string_view key) const {
    return static_cast<std::uint64_t>(numbers.at(key));
  }
};

struct Generator {
  std::string_view name;
  std::vector<Key> keys;
  bool takes_mesh;
  Result<SceneSource> (*make)(const Values&, const SceneLoader&);
};

Key triangles_key(double fallback) {
  return {"triangles", fallback, 1, static_cast<double>(kMostTriangles)};
}

Error invalid(std::string message) {
  return {Code::kInvalidArgument, std::move(message), "GENERATOR_VALUE"};
}

const std::vector<Generator>& all_generators() {
  using Made = Result<SceneSource>;
  static const std::vector<Generator> kGenerators = {
      {"terrain",
       {triangles_key(100'000)},
       false,
       [](const Values& v, const SceneLoader&) -> Made {
         return make_terrain(v.count("triangles"));
       }},
      {"city",
       {{"boxes", 0, 1, kMostTriangles / 12}, triangles_key(0)},
       false,
       [](const Values& v, const SceneLoader&) -> Made {
         const std::uint64_t boxes = v.count("boxes"), triangles = v.count("triangles");
         if (boxes > 0 && triangles > 0)
           return invalid("gen:city takes boxes or triangles, not both");
         const std::uint64_t asked = boxes > 0 ? boxes : (triangles + 11) / 12;
         return make_city(asked > 0 ? asked : kDefaultBoxes, kGeneratorSeed);
       }},
      {"village",
       {triangles_key(100'000)},
       false,
       [](const Values& v, const SceneLoader&) -> Made {
         return make_village((v.count("triangles") + kTrianglesPerHouse - 1) / kTrianglesPerHouse);
       }},
      {"herd",
       {{"copies", 10, 1, 100'000}},
       true,
       [](const Values& v, const SceneLoader& load) -> Made {
         auto animal = load(v.mesh);
         if (!animal.ok()) return animal.error();
         const std::uint64_t copies = v.count("copies");
         if (animal->unique_triangles() * copies > kMostTriangles) {
           return invalid(fmt::format("{} copies of {} triangles are over the limit of {}", copies,
                                      animal->unique_triangles(), kMostTriangles));
         }
         return make_herd(*animal, copies, kGeneratorSeed);
       }},
      {"shuffled",
       {{"seed", kGeneratorSeed, 0, 1e15}},
       true,
       [](const Values& v, const SceneLoader& load) -> Made {
         auto scene = load(v.mesh);
         if (!scene.ok()) return scene.error();
         return make_shuffled(*std::move(scene), v.count("seed"));
       }},
      {"box",
       {},
       true,
       [](const Values& v, const SceneLoader& load) -> Made {
         auto scene = load(v.mesh);
         if (!scene.ok()) return scene.error();
         return make_boxed(*std::move(scene));
       }},
      {"swarm",
       {triangles_key(50'000)},
       false,
       [](const Values& v, const SceneLoader&) -> Made {
         return make_swarm(v.count("triangles"));
       }},
      {"stadium",
       {},
       false,
       [](const Values&, const SceneLoader&) -> Made { return make_stadium(); }},
      {"slivers",
       {triangles_key(100'000)},
       false,
       [](const Values& v, const SceneLoader&) -> Made {
         return make_slivers(v.count("triangles"), kGeneratorSeed);
       }},
      {"icosphere",
       {{"level", 5, 0, 10}, {"offset", 0, -1e15, 1e15, false}},
       false,
       [](const Values& v, const SceneLoader&) -> Made {
         return make_icosphere(static_cast<int>(v.count("level")), v.number("offset"));
       }},
      {"spheres",
       {{"copies", 64, 2, 100'000}, {"level", 2, 0, 5}, {"offset", 0, -1e9, 1e9, false}},
       false,
       [](const Values& v, const SceneLoader&) -> Made {
         return make_spheres(v.count("copies"), static_cast<int>(v.count("level")),
                             v.number("offset"), kGeneratorSeed);
       }},
      {"grid",
       {triangles_key(100'000)},
       false,
       [](const Values& v, const SceneLoader&) -> Made { return make_grid(v.count("triangles")); }},
      {"wall",
       {triangles_key(10'000), {"share", 0.3, 0, 1, false}, {"at", 0.62, 0, 1, false}},
       false,
       [](const Values& v, const SceneLoader&) -> Made {
         return make_wall(v.count("triangles"), v.number("share"), v.number("at"), kGeneratorSeed);
       }},
  };
  return kGenerators;
}

std::string keys_of(const Generator& generator) {
  std::string text;
  for (const Key& key : generator.keys) text += fmt::format(" {}", key.name);
  if (generator.takes_mesh) text += " mesh";
  return text.empty() ? " none" : text;
}

Result<double> parse_number(const Key& key, std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_number = error == std::errc() && end == text.data() + text.size();
  if (!is_number || (key.whole && value != static_cast<double>(static_cast<std::int64_t>(
                                               value > -1e15 && value < 1e15 ? value : 0.5)))) {
    return invalid(
        fmt::format("{}: \"{}\" is not a {}number", key.name, text, key.whole ? "whole " : ""));
  }
  if (!(value >= key.low && value <= key.high)) {
    return invalid(fmt::format("{} = {} is outside {} to {}", key.name, text, key.low, key.high));
  }
  return value;
}

Status set_value(const Generator& generator, Values& values, std::string_view pair) {
  const std::size_t equals = pair.find('=');
  const std::string_view name = pair.substr(0, equals);
  const std::string_view text =
      equals == std::string_view::npos ? std::string_view() : pair.substr(equals + 1);
  if (generator.takes_mesh && name == "mesh") {
    values.mesh = text;
    return {};
  }
  for (const Key& key : generator.keys) {
    if (key.name != name) continue;
    auto number = parse_number(key, text);
    if (!number.ok()) return number.error();
    values.numbers[key.name] = *number;
    return {};
  }
  return invalid(fmt::format("gen:{} has no key \"{}\"; there are:{}", generator.name, name,
                             keys_of(generator)));
}

}  // namespace

std::string list_generators() {
  std::string text;
  for (const Generator& generator : all_generators()) {
    text += fmt::format("gen:{}", generator.name);
    char separator = '?';
    for (const Key& key : generator.keys) {
      text += fmt::format("{}{}=", separator, key.name);
      if (key.fallback >= key.low) text += fmt::format("{}", key.fallback);
      separator = '&';
    }
    if (generator.takes_mesh) text += fmt::format("{}mesh=FILE", separator);
    text += '\n';
  }
  return text;
}

Result<SceneSource> generate(std::string_view spec, const SceneLoader& load) {
  const std::size_t question = spec.find('?');
  const std::string_view name = spec.substr(0, question);
  const Generator* generator = nullptr;
  for (const Generator& candidate : all_generators()) {
    if (candidate.name == name) generator = &candidate;
  }
  if (generator == nullptr) {
    return invalid(fmt::format("no generator \"{}\"; there are:\n{}", name, list_generators()));
  }
  Values values;
  for (const Key& key : generator->keys) values.numbers[key.name] = key.fallback;
  std::string_view rest =
      question == std::string_view::npos ? std::string_view() : spec.substr(question + 1);
  while (!rest.empty()) {
    const std::size_t end = rest.find('&');
    if (auto set = set_value(*generator, values, rest.substr(0, end)); !set.ok()) {
      return set.error();
    }
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
  }
  if (generator->takes_mesh && values.mesh.empty()) {
    return invalid(fmt::format("gen:{} needs mesh=FILE", name));
  }
  return generator->make(values, load);
}

}  // namespace sightline::bench
