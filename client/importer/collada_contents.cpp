// Notes arrays, accessors and inputs by their ids on one way through the tags, and compares them at
// the end, as an element may name later ones.
#include "client/importer/collada_contents.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "client/importer/collada_numbers.h"
#include "client/importer/formats/text.h"
#include "client/importer/imported_scene.h"
#include "client/importer/node_name.h"
#include "client/importer/xml_tags.h"

namespace sightline::client::importer {
namespace {

constexpr std::uint64_t kMost = 0xFFFFFFFF;  // products of two are no larger than 64 bits
constexpr double kMostOff = 2e-3;            // share of the length of an axis
constexpr std::string_view kLooks[] = {"NORMAL",   "TEXCOORD",   "COLOR",       "TANGENT",
                                       "BINORMAL", "TEXTANGENT", "TEXBINORMAL", "UV"};
constexpr std::string_view kPrimitives[] = {"triangles", "polylist", "polygons",  "tristrips",
                                            "trifans",   "lines",    "linestrips"};

template <class Words>
bool holds(const Words& words, std::string_view word) {
  return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

// Assimp reads on over characters that XML does not have.
Status check_characters(std::string_view text) {
  if (!text.starts_with('<') && !text.starts_with("\xEF\xBB\xBF<")) return {};  // UTF-16, or none
  const auto is_control = [](char c) {
    return static_cast<unsigned char>(c) < ' ' && c != '\t' && c != '\n' && c != '\r';
  };
  const auto control = std::find_if(text.begin(), text.end(), is_control);
  if (control != text.end()) {
    return import_error(fmt::format("its byte {} is a control character, which XML does not have",
                                    control - text.begin()));
  }
  const std::string head = formats::in_lower_case(text.substr(0, text.find("?>")));
  const bool is_other = head.find("encoding") != head.npos && head.find("utf-8") == head.npos;
  if (is_other || is_utf8(text)) return {};
  return import_error("it is not in UTF-8, as it must be if it does not name another encoding");
}

std::string_view target_of(std::string_view reference) {
  return reference.starts_with('#') ? reference.substr(1) : reference;
}

struct Array {
  std::uint64_t count = 0;
  std::string_view text;
  bool is_of_numbers = false;
};

struct Accessor {
  std::string_view array;
  std::uint64_t count = 0, stride = 1, offset = 0, params = 0;
  std::array<int, 3> axes{};  // how many params are named X, Y and Z
};

class Contents {
 public:
  Status read(std::string_view text) {
    XmlTags tags(text);
    while (const auto tag = tags.next()) {
      if (tag->is_end) {
        if (!open_.empty()) open_.pop_back();
        continue;
      }
      if (Status good = begin(*tag); !good) return good;
      if (!tag->is_empty) open_.push_back(tag->name);
    }
    for (const std::string_view source : used_) {
      if (Status good = check(source); !good) return good;
    }
    return {};
  }

 private:
  Status begin(const XmlTag& tag) {
    const std::string_view parent = open_.empty() ? std::string_view() : open_.back();
    if (tag.name == "source") source_ = tag.attribute("id");
    if (tag.name == "geometry") geometry_ = tag.attribute("id");
    if (tag.name == "vertices") positions_here_ = 0;
    if (holds(kPrimitives, tag.name)) stride_ = 1, vertex_.reset();
    if (tag.name.ends_with("_array")) return begin_array(tag);
    if (tag.name == "accessor") return begin_accessor(tag);
    if (tag.name == "unit" && parent == "asset") return check_unit(tag.attribute("meter"));
    if (tag.name == "param" && parent == "accessor") add_param(tag.attribute("name"));
    if (tag.name == "input") return begin_input(tag, parent);
    if (tag.name == "p" && holds(kPrimitives, parent)) return check_corners(tag.text);
    if (parent == "node") return check_transform(tag);
    if (parent == "visual_scene") return refuse_transform(tag);
    return {};
  }

  // Leaves the value as it is if the attribute is missing.
  static Status read_integer(const XmlTag& tag, std::string_view key, std::uint64_t& value) {
    std::string_view text = tag.attribute(key);
    if (text.empty()) return {};
    text = formats::trimmed(text);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc() && end == text.data() + text.size() && value <= kMost) return {};
    return import_error(fmt::format("<{}>: {} is '{}', must be an integer from 0", tag.name, key,
                                    formats::shown(text)));
  }

  Status begin_array(const XmlTag& tag) {
    Array array{.text = tag.text, .is_of_numbers = tag.name == "float_array"};
    Status good = read_integer(tag, "count", array.count);
    arrays_[tag.attribute("id")] = array;
    return good;
  }

  Status begin_accessor(const XmlTag& tag) {
    Accessor accessor{.array = target_of(tag.attribute("source"))};
    Status good = read_integer(tag, "count", accessor.count);
    if (good) good = read_integer(tag, "stride", accessor.stride);
    if (good) good = read_integer(tag, "offset", accessor.offset);
    accessors_[source_] = accessor;
    return good;
  }

  void add_param(std::string_view name) {
    constexpr std::string_view kAxes[] = {"X", "Y", "Z"};
    Accessor& accessor = accessors_[source_];
    ++accessor.params;
    for (std::size_t k = 0; k < accessor.axes.size(); ++k) {
      if (name == kAxes[k]) ++accessor.axes[k];
    }
  }

  Status begin_input(const XmlTag& tag, std::string_view parent) {
    const std::string_view semantic = tag.attribute("semantic");
    if (semantic == "POSITION") {
      const bool is_of_vertices = parent == "vertices";
      if (!is_of_vertices || positions_here_++ > 0) {
        return import_error(
            fmt::format("geometry '{}': it has a second POSITION", formats::shown(geometry_)));
      }
      positions_.insert(target_of(tag.attribute("source")));
    }
    if (!holds(kLooks, semantic)) used_.insert(target_of(tag.attribute("source")));
    if (!holds(kPrimitives, parent)) return {};
    std::uint64_t offset = 0;
    Status good = read_integer(tag, "offset", offset);
    stride_ = std::max(stride_, offset + 1);
    if (semantic == "VERTEX") vertex_ = offset;
    return good;
  }

  // Assimp takes numbers below 0 and those that an int does not hold for 0.
  Status check_corners(std::string_view text) const {
    if (!vertex_) return {};
    std::uint64_t i = 0;
    for (std::string_view word = take_collada_word(text); !word.empty();
         word = take_collada_word(text), ++i) {
      if (i % stride_ != *vertex_) continue;
      int number = -1;
      std::from_chars(word.data(), word.data() + word.size(), number);
      if (number < 0) {
        return import_error(fmt::format("geometry '{}': a polygon names vertex {}",
                                        formats::shown(geometry_), formats::shown(word)));
      }
    }
    return {};
  }

  static Status check_unit(std::string_view meter) {
    const auto value = collada_number(meter);
    if (meter.empty() || (value && *value > 0)) return {};
    return import_error(fmt::format("its unit is '{}' meters", formats::shown(meter)));
  }

  // Assimp would move the whole scene.
  static Status refuse_transform(const XmlTag& tag) {
    for (const auto& [name, needed] : kColladaTransforms) {
      if (tag.name == name)
        return import_error(fmt::format("<{}> stands in <visual_scene>, not in a node", name));
    }
    return {};
  }

  static Status check_transform(const XmlTag& tag) {
    for (const auto& [name, needed] : kColladaTransforms) {
      if (tag.name != name) continue;
      std::string_view rest = tag.text;
      std::size_t numbers = 0;
      std::array<double, 9> first{};
      for (std::string_view word = take_collada_word(rest); !word.empty();
           word = take_collada_word(rest)) {
        const auto value = collada_number(word);
        if (!value) return import_error(fmt::format("<{}>: {}", name, value.error().message));
        if (numbers < first.size()) first[numbers] = *value;
        ++numbers;
      }
      if (numbers != needed)
        return import_error(
            fmt::format("<{}> has {} numbers, must have {}", name, numbers, needed));
      const double length = std::hypot(first[0], first[1], first[2]);
      if (name == "rotate" && first[3] != 0 && std::abs(length - 1) > kMostOff) {
        return import_error(
            fmt::format("<rotate> is about an axis of length {:.4g}, which Assimp takes for 1; "
                        "export it with matrices",
                        length));
      }
      if (name == "lookat" && !is_upright(first)) {
        return import_error(
            "<lookat> has an up direction that is not square to its line of sight, and Assimp "
            "skews by it; export it with matrices");
      }
    }
    return {};
  }

  // `n`: where the eye is, where it looks, and what is up.
  static bool is_upright(const std::array<double, 9>& n) {
    const std::array<double, 3> sight{n[3] - n[0], n[4] - n[1], n[5] - n[2]};
    const double along = sight[0] * n[6] + sight[1] * n[7] + sight[2] * n[8];
    return std::abs(along) <=
           kMostOff * std::hypot(sight[0], sight[1], sight[2]) * std::hypot(n[6], n[7], n[8]);
  }

  Status check(std::string_view source) const {
    const auto known = accessors_.find(source);
    if (known == accessors_.end()) return {};  // Assimp refuses what it needs and does not find.
    const Accessor& accessor = known->second;
    const auto wrong = [&](const std::string& what) {
      return import_error(fmt::format("source '{}': {}", formats::shown(source), what));
    };
    if (accessor.params > accessor.stride) {
      return wrong(fmt::format("its accessor has {} params and the stride {}", accessor.params,
                               accessor.stride));
    }
    const auto is_one = [](int count) { return count == 1; };
    if (positions_.contains(source) &&
        !std::all_of(accessor.axes.begin(), accessor.axes.end(), is_one))
      return wrong("its accessor has not one X, one Y and one Z, as positions must have");
    const auto array = arrays_.find(accessor.array);
    if (array == arrays_.end()) return {};
    const std::uint64_t needed = accessor.offset + accessor.count * accessor.stride;
    if (needed > array->second.count) {
      return wrong(fmt::format("its accessor reads {} values of an array that says it has {}",
                               needed, array->second.count));
    }
    return array->second.is_of_numbers ? check_numbers(array->second, source) : Status();
  }

  static Status check_numbers(const Array& array, std::string_view source) {
    std::string_view rest = array.text;
    for (std::uint64_t i = 0; i < array.count; ++i) {
      const std::string_view word = take_collada_word(rest);
      if (word.empty()) return {};  // Assimp refuses arrays that are too short.
      if (const auto value = collada_number(word); !value) {
        return import_error(
            fmt::format("source '{}': {}", formats::shown(source), value.error().message));
      }
    }
    return {};
  }

  std::vector<std::string_view> open_;  // names of the elements around
  std::string_view source_, geometry_;  // ids of the last ones
  int positions_here_ = 0;              // positions of the last <vertices>
  std::uint64_t stride_ = 1;            // the stride of the corners of the last primitive
  std::optional<std::uint64_t> vertex_;
  std::unordered_map<std::string_view, Array> arrays_;
  std::unordered_map<std::string_view, Accessor> accessors_;  // by the id of their source
  std::unordered_set<std::string_view> used_, positions_;     // ids of sources
};

}  // namespace

Status check_collada(std::string_view text) {
  if (Status good = check_characters(text); !good) return good;
  return Contents().read(text);
}

}  // namespace sightline::client::importer
