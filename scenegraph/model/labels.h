// Labels of a node: what a user says of it, as keys and values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "proto/result.h"

namespace sightline::scenegraph::model {

inline constexpr std::size_t kMaxLabels = 64;          ///< The most labels of a node.
inline constexpr std::size_t kMaxLabelKey = 64;        ///< The most bytes of a key.
inline constexpr std::size_t kMaxLabelValue = 256;     ///< The most bytes of a value.
inline constexpr std::size_t kMaxLabelsOfNode = 4096;  ///< The most bytes of all keys and values.

struct Label {
  std::string key;
  std::string value;
  bool operator==(const Label&) const = default;
};

/// The labels of a node in the order in which they were given. Null means that it has none.
/// Revisions share them.
using Labels = std::shared_ptr<const std::vector<Label>>;

/// Checks the limits of one label, that its key is not empty, and that neither its key nor its
/// value has control characters. Errors: kInvalidArgument, with the value and the limit.
Status check_label(const std::string& key, const std::string& value);
/// Checks the limits, and that each key is there once, is not empty, and has no control character.
/// Values have none either. Errors: kInvalidArgument, with the value and the limit.
Status check_labels(const Labels& labels);

/// The memory that labels take, to account for.
std::uint64_t bytes_of_labels(const Labels& labels);

}  // namespace sightline::scenegraph::model
