// One line, or one object, for each warning.
#include "client/cli/verbs/import_warnings.h"

#include <fmt/format.h>

#include "client/cli/reporting.h"
#include "client/cli/terminal.h"

namespace sightline::client::cli::verbs {

void print_import_warnings(const std::vector<importer::Warning>& warnings) {
  for (const importer::Warning& warning : warnings) {
    if (!warning.is_note) print_warning(warning.message);
  }
}

void print_import_notes(const std::vector<importer::Warning>& warnings) {
  for (const importer::Warning& warning : warnings) {
    if (warning.is_note) fmt::print("  note       {}\n", printable(warning.message));
  }
}

Json json_of_warnings(const std::vector<importer::Warning>& warnings) {
  Json out = Json::array();
  for (const importer::Warning& warning : warnings) {
    out.push_back({{"kind", warning.kind},
                   {"count", warning.count},
                   {"first", warning.first},
                   {"message", warning.message}});
  }
  return out;
}

}  // namespace sightline::client::cli::verbs
