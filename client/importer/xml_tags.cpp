// Looks for "<" and ">" outside of quotes.
#include "client/importer/xml_tags.h"

#include <algorithm>

namespace sightline::client::importer {
namespace {

constexpr std::size_t kNowhere = std::string_view::npos;
constexpr std::string_view kBlanks = " \t\r\n";

// Where a tag that begins at `at` ends.
std::size_t end_of_tag(std::string_view text, std::size_t at) {
  while ((at = text.find_first_of("\"'>", at)) != kNowhere && text[at] != '>') {
    at = text.find(text[at], at + 1);
    if (at == kNowhere) return kNowhere;
    ++at;
  }
  return at;
}

}  // namespace

std::string_view XmlTag::attribute(std::string_view key) const {
  for (std::size_t at = attributes.find(key); at != kNowhere; at = attributes.find(key, at + 1)) {
    const std::size_t open = attributes.find_first_not_of(kBlanks, at + key.size());
    if (at == 0 || attributes[at - 1] > ' ' || open == kNowhere || attributes[open] != '=')
      continue;
    const std::size_t quote = attributes.find_first_not_of(kBlanks, open + 1);
    if (quote == kNowhere || (attributes[quote] != '"' && attributes[quote] != '\'')) continue;
    const std::size_t end = attributes.find(attributes[quote], quote + 1);
    if (end != kNowhere) return attributes.substr(quote + 1, end - quote - 1);
  }
  return {};
}

std::optional<XmlTag> XmlTags::next() {
  struct Skipped {
    std::string_view begin, end;
  };
  constexpr Skipped kSkipped[] = {{"<!--", "-->"}, {"<![CDATA[", "]]>"}, {"<?", "?>"}, {"<!", ">"}};
  while ((at_ = text_.find('<', at_)) != kNowhere) {
    const std::string_view rest = text_.substr(at_);
    const Skipped* const skipped =
        std::find_if(std::begin(kSkipped), std::end(kSkipped),
                     [&](const Skipped& part) { return rest.starts_with(part.begin); });
    if (skipped != std::end(kSkipped)) {
      const std::size_t end = text_.find(skipped->end, at_ + skipped->begin.size());
      if (end == kNowhere) return {};
      at_ = end + skipped->end.size();
      continue;
    }
    const std::size_t end = end_of_tag(text_, at_);
    if (end == kNowhere) return {};
    std::string_view inside = text_.substr(at_ + 1, end - at_ - 1);
    XmlTag tag;
    tag.is_end = inside.starts_with('/');
    if (tag.is_end) inside.remove_prefix(1);
    tag.is_empty = !tag.is_end && inside.ends_with('/');
    if (tag.is_empty) inside.remove_suffix(1);
    const std::size_t name = std::min(inside.find_first_of(kBlanks), inside.size());
    tag.name = inside.substr(0, name);
    tag.attributes = inside.substr(name);
    at_ = end + 1;
    tag.text = text_.substr(at_, text_.find('<', at_) - at_);
    return tag;
  }
  return {};
}

}  // namespace sightline::client::importer
