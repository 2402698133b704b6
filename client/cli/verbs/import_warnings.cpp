// One line, or one object, for each warning.
#include "client/cli/verbs/import_warnings.h"

#include "client/cli/reporting.h"

namespace sightline::client::cli::verbs {

void print_import_warnings(const std::vector<importer::Warning>& warnings) {
  for (const importer::Warning& warning : warnings) print_warning(warning.message);
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
