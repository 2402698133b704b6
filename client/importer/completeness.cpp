// Looks at the end of the file.
#include "client/importer/completeness.h"

#include <fmt/format.h>

#include "client/importer/formats/text.h"
#include "client/importer/imported_scene.h"

namespace sightline::client::importer {

Status check_complete(std::string_view bytes) {
  constexpr std::string_view kBegin = "ISO-10303-21", kEnd = "END-ISO-10303-21;";
  if (!formats::trimmed(bytes.substr(0, 100)).starts_with(kBegin) ||
      formats::trimmed(bytes).ends_with(kEnd))
    return {};
  return import_error(fmt::format("the file is cut off: it does not end with {}", kEnd));
}

}  // namespace sightline::client::importer
