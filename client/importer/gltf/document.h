// The JSON of a glTF file: typed access to its values, and messages that say where a wrong one is.
// Internal to the importer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/importer/gltf/refusal.h"

namespace sightline::client::importer::gltf {

/// An object of the file. All functions refuse a value of another type than they return; an absent
/// value is the default. Valid as long as the document.
class Item {
 public:
  /// `where`: its place for messages, for example "nodes[3]". Refuses a value that is no object.
  Item(const nlohmann::json& value, std::string where);

  const std::string& where() const { return where_; }
  bool has(const char* key) const { return value_->contains(key); }
  bool has_object(const char* key) const { return has(key) && (*value_)[key].is_object(); }

  std::optional<std::uint64_t> find_integer(const char* key) const;
  std::uint64_t integer(const char* key) const;  ///< refuses an absent value, too
  std::uint64_t integer(const char* key, std::uint64_t fallback) const;
  bool flag(const char* key, bool fallback) const;
  std::string text(const char* key) const;
  std::optional<Item> object(const char* key) const;
  /// The object of this name below `extensions`.
  std::optional<Item> extension(const char* name) const;
  std::vector<Item> objects(const char* key) const;
  std::vector<std::uint64_t> integers(const char* key) const;
  std::vector<double> numbers(const char* key) const;
  std::vector<std::string> texts(const char* key) const;
  /// Members and the integers that they have.
  std::vector<std::pair<std::string, std::uint64_t>> named_integers() const;

  template <std::size_t kCount>
  std::optional<std::array<double, kCount>> numbers(const char* key) const {
    if (!has(key)) return {};
    const std::vector<double> list = numbers(key);
    if (list.size() != kCount)
      refuse("{}: {} has {} numbers, must have {}", where_, key, list.size(), kCount);
    std::array<double, kCount> out{};
    for (std::size_t i = 0; i < kCount; ++i) out[i] = list[i];
    return out;
  }

 private:
  const nlohmann::json* find(const char* key) const;
  const nlohmann::json* find_list(const char* key) const;
  [[noreturn]] void refuse_type(const char* key, const nlohmann::json& value,
                                const char* expected) const;

  const nlohmann::json* value_;
  std::string where_;
};

class Document {
 public:
  /// Refuses text that is no JSON object in UTF-8.
  explicit Document(std::string_view json);

  Item root() const { return {root_, "the file"}; }
  std::size_t count(const char* list) const;
  /// An element of a list of the file, such as "nodes". Refuses an index that it does not have;
  /// `by` is who names it.
  Item at(const char* list, std::uint64_t index, std::string_view by) const;

 private:
  nlohmann::json root_;
};

}  // namespace sightline::client::importer::gltf
