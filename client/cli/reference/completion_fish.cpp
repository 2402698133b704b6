// Completion for fish.
#include <fmt/format.h>

#include <algorithm>

#include "client/cli/reference/completion.h"

namespace sightline::client::cli::reference {
namespace {

std::string fish_quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "'";
}

/// The flags of `complete` for a value: -x takes no file, -r takes one.
std::string fish_value(const Value& value) {
  switch (value.kind) {
    case Value::Kind::kNone:
      return "";
    case Value::Kind::kText:
      return " -x";
    case Value::Kind::kFile:
      return " -r -F";
    case Value::Kind::kDirectory:
      return " -x -a '(__fish_complete_directories)'";
    case Value::Kind::kScene:
      return " -x -a '(__sightline_scenes)'";
    case Value::Kind::kChoices:
      break;
  }
  return fmt::format(" -x -a {}", fish_quoted(fmt::format("{}", fmt::join(value.choices, " "))));
}

/// `condition` holds the words after -n; empty: always.
std::string complete_option(const Option& option, const std::string& condition) {
  std::string line = "complete -c sightline" + condition;
  for (const std::string& name : option.names)
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  return line + fish_value(option.value) + " -d " + fish_quoted(option.help) + "\n";
}

std::string condition_of(const Verb& verb) {
  return fmt::format(" -n {}", fish_quoted("__sightline_at " + fish_quoted(verb.path)));
}

/// Patterns of "VERB OPTION" for options that take a value, and of "VERB NAME" for verbs.
std::string value_patterns(std::span<const Verb> verbs) {
  std::string text;
  for (const Verb& verb : verbs) {
    for (const Option& option : verb.options) {
      if (option.value.kind == Value::Kind::kNone) continue;
      for (const std::string& name : option.names)
        text += " " + fish_quoted((verb.path.empty() ? "*" : verb.path) + " " + name);
    }
  }
  return text;
}

std::string verb_patterns(std::span<const Verb> verbs) {
  std::string text;
  for (const Verb& verb : verbs) {
    for (const std::string& name : verb.verbs) text += " " + fish_quoted(verb.path + " " + name);
  }
  return text;
}

constexpr const char* kFishSteps = R"(
# Scenes whose names mean nothing to a shell.
function __sightline_scenes
    sightline scene ls --deadline 2 2>/dev/null | awk 'NR > 1 && $1 ~ /^[a-z0-9][a-z0-9._-]*$/ {{ print $1 }}'
end

# Prints the verb that was typed so far, and how many arguments of it there are.
function __sightline_state
    set -l at ''
    set -l count 0
    set -l skip 0
    set -l typed (commandline -opc)
    for word in $typed[2..-1]
        if test $skip = 1
            set skip 0
            continue
        end
        switch $word
            case '--*=*'
            case '-*'
                switch "$at $word"
                    case{}
                        set skip 1
                end
            case '*'
                switch "$at $word"
                    case{}
                        set at (string trim -- "$at $word")
                        set count 0
                    case '*'
                        set count (math $count + 1)
                end
        end
    end
    echo "$at"
    echo $count
end

# VERB [COUNT]: whether this verb was typed, and this many arguments of it.
function __sightline_at
    set -l state (__sightline_state)
    test "$state[1]" = "$argv[1]"
    and begin
        test (count $argv) -lt 2
        or test "$state[2]" = "$argv[2]"
    end
end

complete -c sightline -f
)";

}  // namespace

std::string fish_completion(std::span<const Verb> verbs) {
  std::string text =
      "# Completion of sightline for fish, as `sightline completion fish` prints it.\n" +
      fmt::format(kFishSteps, value_patterns(verbs), verb_patterns(verbs));
  for (const Verb& verb : verbs) {
    const std::string condition = condition_of(verb);
    for (const std::string& name : verb.verbs) {
      const std::string path = join_path(verb.path, name);
      const auto below = std::find_if(verbs.begin(), verbs.end(),
                                      [&path](const Verb& other) { return other.path == path; });
      text += fmt::format("complete -c sightline{} -a {} -d {}\n", condition, fish_quoted(name),
                          fish_quoted(below->summary));
    }
    // Every verb takes the options of the program, and -h of its own is among them.
    for (const Option& option : verb.options) {
      const bool is_help = option.names.back() == "--help";
      if (verb.path.empty() || !is_help)
        text += complete_option(option, verb.path.empty() ? "" : condition);
    }
    for (std::size_t k = 0; k < verb.arguments.size(); ++k) {
      text +=
          fmt::format("complete -c sightline -n {}{}\n",
                      fish_quoted(fmt::format("__sightline_at {} {}", fish_quoted(verb.path), k)),
                      fish_value(verb.arguments[k].value));
    }
  }
  return text;
}

}  // namespace sightline::client::cli::reference
