// Checks the type of each value when it is asked for.
#include "client/importer/gltf/document.h"

#include <cmath>

namespace sightline::client::importer::gltf {
namespace {

using nlohmann::json;

constexpr std::size_t kShown = 40;                 // characters of a wrong value
constexpr double kMostInteger = 9007199254740992;  // doubles are all integers below, 2^53

std::string shown(const json& value) {
  if (value.is_array()) return fmt::format("a list of {}", value.size());
  if (value.is_object()) return "an object";
  const std::string text = value.dump();
  return text.size() <= kShown ? text : text.substr(0, kShown) + "...";
}

std::optional<std::uint64_t> integer_of(const json& value) {
  if (value.is_number_unsigned()) return value.get<std::uint64_t>();
  if (!value.is_number_float()) return {};
  const auto number = value.get<double>();
  if (!(number >= 0 && number <= kMostInteger) || std::floor(number) != number) return {};
  return static_cast<std::uint64_t>(number);
}

// The message without the prefix with which the parser begins.
std::string reason(const json::exception& e) {
  const std::string_view said = e.what();
  const std::size_t begin = said.find("] ");
  return std::string(begin == std::string_view::npos ? said : said.substr(begin + 2));
}

json parsed(std::string_view text) {
  try {
    return json::parse(text);
  } catch (const json::exception& e) {
    refuse("its JSON is damaged: {}", reason(e));
  }
}

}  // namespace

Item::Item(const json& value, std::string where) : value_(&value), where_(std::move(where)) {
  if (!value.is_object()) refuse("{} is {}, must be an object", where_, shown(value));
}

const json* Item::find(const char* key) const {
  const auto found = value_->find(key);
  return found == value_->end() ? nullptr : &*found;
}

void Item::refuse_type(const char* key, const json& value, const char* expected) const {
  refuse("{}: {} is {}, must be {}", where_, key, shown(value), expected);
}

const json* Item::find_list(const char* key) const {
  const json* const value = find(key);
  if (value != nullptr && !value->is_array()) refuse_type(key, *value, "a list");
  return value;
}

std::optional<std::uint64_t> Item::find_integer(const char* key) const {
  const json* const value = find(key);
  if (value == nullptr) return {};
  const auto integer = integer_of(*value);
  if (!integer) refuse_type(key, *value, "an integer from 0");
  return integer;
}

std::uint64_t Item::integer(const char* key) const {
  const auto value = find_integer(key);
  if (!value) refuse("{}: {} is missing", where_, key);
  return *value;
}

std::uint64_t Item::integer(const char* key, std::uint64_t fallback) const {
  return find_integer(key).value_or(fallback);
}

bool Item::flag(const char* key, bool fallback) const {
  const json* const value = find(key);
  if (value == nullptr) return fallback;
  if (!value->is_boolean()) refuse_type(key, *value, "true or false");
  return value->get<bool>();
}

std::string Item::text(const char* key) const {
  const json* const value = find(key);
  if (value == nullptr) return {};
  if (!value->is_string()) refuse_type(key, *value, "a text");
  return value->get<std::string>();
}

std::optional<Item> Item::object(const char* key) const {
  const json* const value = find(key);
  if (value == nullptr) return {};
  return Item(*value, fmt::format("{}.{}", where_, key));
}

std::optional<Item> Item::extension(const char* name) const {
  const auto extensions = object("extensions");
  return extensions ? extensions->object(name) : std::nullopt;
}

std::vector<Item> Item::objects(const char* key) const {
  std::vector<Item> out;
  const json* const list = find_list(key);
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i)
    out.emplace_back((*list)[i], fmt::format("{}.{}[{}]", where_, key, i));
  return out;
}

std::vector<std::uint64_t> Item::integers(const char* key) const {
  std::vector<std::uint64_t> out;
  const json* const list = find_list(key);
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
    const auto integer = integer_of((*list)[i]);
    if (!integer) refuse_type(key, (*list)[i], "a list of integers from 0");
    out.push_back(*integer);
  }
  return out;
}

std::vector<double> Item::numbers(const char* key) const {
  std::vector<double> out;
  const json* const list = find_list(key);
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
    if (!(*list)[i].is_number()) refuse_type(key, (*list)[i], "a list of numbers");
    out.push_back((*list)[i].get<double>());
  }
  return out;
}

std::vector<std::string> Item::texts(const char* key) const {
  std::vector<std::string> out;
  const json* const list = find_list(key);
  for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
    if (!(*list)[i].is_string()) refuse_type(key, (*list)[i], "a list of texts");
    out.push_back((*list)[i].get<std::string>());
  }
  return out;
}

std::vector<std::pair<std::string, std::uint64_t>> Item::named_integers() const {
  std::vector<std::pair<std::string, std::uint64_t>> out;
  for (const auto& [name, value] : value_->items()) {
    const auto integer = integer_of(value);
    if (!integer) refuse_type(name.c_str(), value, "an integer from 0");
    out.emplace_back(name, *integer);
  }
  return out;
}

Document::Document(std::string_view text) : root_(parsed(text)) {
  if (!root_.is_object()) refuse("its JSON is {}, must be an object", shown(root_));
}

std::size_t Document::count(const char* list) const {
  const auto found = root_.find(list);
  if (found == root_.end()) return 0;
  if (!found->is_array()) refuse("{} is {}, must be a list", list, shown(*found));
  return found->size();
}

Item Document::at(const char* list, std::uint64_t index, std::string_view by) const {
  const std::size_t size = count(list);
  if (index >= size) refuse("{} names {}[{}], but there are {}", by, list, index, size);
  return {root_[list][index], fmt::format("{}[{}]", list, index)};
}

}  // namespace sightline::client::importer::gltf
