// Reads words between blanks and line ends.
#include "client/importer/collada_numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "client/importer/formats/text.h"
#include "client/importer/imported_scene.h"

namespace sightline::client::importer {

std::string_view take_collada_word(std::string_view& text) {
  constexpr std::string_view kBetweenWords = " \t\r\n";
  const std::size_t begin = std::min(text.find_first_not_of(kBetweenWords), text.size());
  const std::size_t end = std::min(text.find_first_of(kBetweenWords, begin), text.size());
  const std::string_view word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

Result<double> collada_number(std::string_view word) {
  constexpr std::size_t kMostDigits = 19;  // Assimp takes integers of more digits for others.
  std::string plain(word);
  const std::size_t comma = plain.find(',');
  if (comma != std::string::npos) plain[comma] = '.';
  const auto value = formats::number(plain);
  if (!value) return import_error(fmt::format("'{}' is no number", formats::shown(word)));
  const std::size_t sign = plain.starts_with('-') || plain.starts_with('+') ? 1 : 0;
  if (plain.find_first_not_of("0123456789", sign) > sign + kMostDigits &&
      plain.size() > sign + kMostDigits) {
    return import_error(fmt::format("'{}' has more than {} digits before its point",
                                    formats::shown(word), kMostDigits));
  }
  return *value;
}

}  // namespace sightline::client::importer
