// The tags of a text in XML. Internal to the importer.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace sightline::client::importer {

struct XmlTag {
  std::string_view name;
  std::string_view attributes;
  std::string_view text;  ///< what follows it, up to the next "<"
  bool is_end = false;    ///< </name>
  bool is_empty = false;  ///< <name/>

  /// The value as it is written. Empty: there is no such attribute.
  std::string_view attribute(std::string_view key) const;
};

/// Goes through the tags of a text, without comments, CDATA, instructions and declarations. It does
/// not check whether the text is well formed.
class XmlTags {
 public:
  explicit XmlTags(std::string_view text) : text_(text) {}

  /// Nothing: there are no more.
  std::optional<XmlTag> next();

 private:
  std::string_view text_;
  std::size_t at_ = 0;
};

}  // namespace sightline::client::importer
