// Manual pages of a program, from the same text as its --help.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace sightline::client::cli::reference {

struct ManualPage {
  std::string file;  ///< "sightline-scene-import.1"
  std::string text;  ///< roff, macros of man(7)
};

/// A page for the program and one for each verb. `source` stands at the foot of the pages: the name
/// and version of what they belong to. `section` is 1 for commands and 8 for those of operators.
std::vector<ManualPage> manual_of(const CLI::App& program, int section, const std::string& source);

}  // namespace sightline::client::cli::reference
