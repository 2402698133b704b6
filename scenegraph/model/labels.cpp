// Checks labels, and counts their memory.
#include "scenegraph/model/labels.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

namespace sightline::scenegraph::model {
namespace {

Error bad_label(std::string message, std::string reason) {
  return {Code::kInvalidArgument, std::move(message), std::move(reason)};
}

Error too_much(const std::string& what, std::size_t value, const std::string& unit,
               std::size_t limit, std::string reason) {
  return bad_label(
      what + " " + std::to_string(value) + " " + unit + ", the limit is " + std::to_string(limit),
      std::move(reason));
}

bool is_control(unsigned char c) { return c < ' ' || c == '\x7f'; }

bool has_control(const std::string& text) { return std::ranges::any_of(text, is_control); }

/// The name of a label for messages, with '?' for each control character.
std::string shown(std::string key) {
  std::ranges::replace_if(key, is_control, '?');
  return "label \"" + key + "\"";
}

}  // namespace

Status check_label(const std::string& key, const std::string& value) {
  if (key.empty()) return bad_label("a label has an empty key", "LABEL_KEY_EMPTY");
  if (key.size() > kMaxLabelKey) {
    return too_much("the key of a label has", key.size(), "bytes", kMaxLabelKey,
                    "LABEL_KEY_TOO_LONG");
  }
  if (value.size() > kMaxLabelValue) {
    return too_much("the value of " + shown(key) + " has", value.size(), "bytes", kMaxLabelValue,
                    "LABEL_VALUE_TOO_LONG");
  }
  if (has_control(key) || has_control(value)) {
    return bad_label(shown(key) + " has a control character in its key or its value",
                     "LABEL_CONTROL_CHARACTER");
  }
  return {};
}

Status check_labels(const Labels& labels) {
  if (labels == nullptr) return {};
  if (labels->size() > kMaxLabels)
    return too_much("a node has", labels->size(), "labels", kMaxLabels, "TOO_MANY_LABELS");
  std::size_t bytes = 0;
  std::vector<std::string_view> keys;
  keys.reserve(labels->size());
  for (const Label& label : *labels) {
    if (Status good = check_label(label.key, label.value); !good) return good;
    bytes += label.key.size() + label.value.size();
    keys.push_back(label.key);
  }
  if (bytes > kMaxLabelsOfNode) {
    return too_much("the labels of a node have", bytes, "bytes", kMaxLabelsOfNode,
                    "LABELS_TOO_LONG");
  }
  std::ranges::sort(keys);
  if (const auto twice = std::ranges::adjacent_find(keys); twice != keys.end())
    return bad_label(shown(std::string(*twice)) + " comes twice, the limit is once", "LABEL_TWICE");
  return {};
}

std::uint64_t bytes_of_labels(const Labels& labels) {
  if (labels == nullptr) return 0;
  std::uint64_t bytes = sizeof(std::vector<Label>) + labels->size() * sizeof(Label);
  for (const Label& label : *labels) bytes += label.key.size() + label.value.size();
  return bytes;
}

}  // namespace sightline::scenegraph::model
