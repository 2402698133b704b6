// Two flags, of which one at a time.
#include "client/cli/consistency_flags.h"

#include <CLI/CLI.hpp>

namespace sightline::client::cli {

void add_consistency_flags(CLI::App& verb, Consistency& consistency) {
  CLI::Option* const at_least =
      verb.add_option(
              "--at-least", consistency.at_least,
              "Wait until the scene is at the revision of this token, which update, stream, "
              "watch and cast print")
          ->type_name("TOKEN");
  verb.add_option("--revision", consistency.exact_revision,
                  "As the scene was at this revision, if it is still kept (default: the latest)")
      ->excludes(at_least)
      ->type_name("N");
}

}  // namespace sightline::client::cli
