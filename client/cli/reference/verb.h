// The verbs of a program as values: what completion scripts and manual pages are written from.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace sightline::client::cli::reference {

/// What may stand as an argument, or as the value of an option.
struct Value {
  enum class Kind : std::uint8_t { kNone, kText, kChoices, kFile, kDirectory, kScene };
  Kind kind = Kind::kNone;
  std::vector<std::string> choices{};  ///< the words of kChoices
};

struct Option {
  std::vector<std::string> names{};  ///< "-h" and "--help"; of an argument its name alone
  std::string label{};               ///< what --help has for the value; may be empty
  std::string help{};                ///< with its default and what it needs or excludes
  Value value{};                     ///< kNone: a flag
  bool required = false;
  bool repeated = false;  ///< takes several values
};

struct Verb {
  std::string path{};  ///< "scene import"; of the program itself empty
  std::string summary{};
  std::string details{};  ///< what --help prints below the options
  std::vector<Option> options{};
  std::vector<Option> arguments{};   ///< in their order
  std::vector<std::string> verbs{};  ///< the names of those below it
};

/// The program first, then every verb, each before those below it.
std::vector<Verb> verbs_of(const CLI::App& program);

/// The last word of a path.
std::string name_of(const Verb& verb);

/// `name` below `path`.
std::string join_path(const std::string& path, const std::string& name);

}  // namespace sightline::client::cli::reference
