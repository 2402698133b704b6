// Completion for bash and zsh, which share the tables: functions of the language of both.
#include <fmt/format.h>

#include <algorithm>

#include "client/cli/reference/completion.h"

namespace sightline::client::cli::reference {
namespace {

/// The text in single quotes, in which a single quote cannot stand.
std::string sh_quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// What the scripts call a value. Empty for a flag, which takes none.
std::string sh_value(const Value& value) {
  switch (value.kind) {
    case Value::Kind::kNone:
      return "";
    case Value::Kind::kText:
      return "text";
    case Value::Kind::kFile:
      return "file";
    case Value::Kind::kDirectory:
      return "directory";
    case Value::Kind::kScene:
      return "scene";
    case Value::Kind::kChoices:
      break;
  }
  return fmt::format("choices {}", fmt::join(value.choices, " "));
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

const Verb& verb_at(std::span<const Verb> verbs, const std::string& path) {
  return *std::find_if(verbs.begin(), verbs.end(),
                       [&path](const Verb& verb) { return verb.path == path; });
}

/// A function that prints the rows NAME:HELP of a verb.
std::string rows_function(const std::string& name, std::span<const Verb> verbs,
                          std::vector<std::string> (*rows_of)(std::span<const Verb>, const Verb&)) {
  std::string text = name + "() {\n  case \"$1\" in\n";
  for (const Verb& verb : verbs) {
    const auto rows = rows_of(verbs, verb);
    if (rows.empty()) continue;
    text += fmt::format("    {}) printf '%s\\n'", sh_quoted(verb.path));
    for (const std::string& row : rows) text += " \\\n      " + sh_quoted(row);
    text += " ;;\n";
  }
  return text + "  esac\n}\n";
}

std::vector<std::string> verb_rows(std::span<const Verb> verbs, const Verb& verb) {
  std::vector<std::string> rows;
  rows.reserve(verb.verbs.size());
  for (const std::string& name : verb.verbs)
    rows.push_back(name + ":" + verb_at(verbs, join_path(verb.path, name)).summary);
  return rows;
}

/// The rows NAME:HELP of a verb's options. Every verb takes those of the program.
std::vector<std::string> option_rows(std::span<const Verb> verbs, const Verb& verb) {
  std::vector<std::string> rows;
  const auto append = [&rows](const Verb& from, bool with_short) {
    for (const Option& option : from.options) {
      const bool has_short = option.names.front().size() == 2;
      if (!with_short && has_short) continue;
      for (const std::string& name : option.names)
        rows.push_back(name + ":" + first_line(option.help));
    }
  };
  append(verb, true);
  if (!verb.path.empty()) append(verbs.front(), false);
  return rows;
}

std::string is_verb_function(std::span<const Verb> verbs) {
  std::string text = "_sightline_is_verb() {\n  case \"$1 $2\" in\n";
  for (const Verb& verb : verbs) {
    for (const std::string& name : verb.verbs)
      text += fmt::format("    {}) return 0 ;;\n", sh_quoted(verb.path + " " + name));
  }
  return text + "    *) return 1 ;;\n  esac\n}\n";
}

std::string option_values_function(std::span<const Verb> verbs) {
  std::string own, shared;
  for (const Verb& verb : verbs) {
    for (const Option& option : verb.options) {
      if (option.value.kind == Value::Kind::kNone) continue;
      for (const std::string& name : option.names) {
        const bool of_program = verb.path.empty();
        const std::string pattern =
            of_program ? "*" + sh_quoted(" " + name) : sh_quoted(verb.path + " " + name);
        (of_program ? shared : own) +=
            fmt::format("    {}) echo {} ;;\n", pattern, sh_quoted(sh_value(option.value)));
      }
    }
  }
  return "_sightline_value() {\n  case \"$1 $2\" in\n" + own + shared + "  esac\n}\n";
}

std::string arguments_function(std::span<const Verb> verbs) {
  std::string text = "_sightline_argument() {\n  case \"$1 $2\" in\n";
  for (const Verb& verb : verbs) {
    for (std::size_t k = 0; k < verb.arguments.size(); ++k)
      text += fmt::format("    {}) echo {} ;;\n", sh_quoted(fmt::format("{} {}", verb.path, k)),
                          sh_quoted(sh_value(verb.arguments[k].value)));
  }
  return text + "  esac\n}\n";
}

/// `at` is the verb that was typed so far, `value` what the next word is a value of, `count` how
/// many arguments of the verb there are: variables of the caller.
constexpr const char* kShSteps = R"sh(
# Scenes whose names mean nothing to a shell.
_sightline_scenes() {
  sightline scene ls --deadline 2 2>/dev/null |
    awk 'NR > 1 && $1 ~ /^[a-z0-9][a-z0-9._-]*$/ { print $1 }'
}

_sightline_step() {
  if [[ -n "$value" ]]; then value=''; return; fi
  case "$1" in
    --*=*) ;;
    -?*) value="$(_sightline_value "$at" "$1")" ;;
    *)
      if _sightline_is_verb "$at" "$1"; then
        at="${at:+$at }$1"
        count=0
      else
        count=$((count + 1))
      fi ;;
  esac
}
)sh";

constexpr const char* kBash = R"sh(
_sightline() {
  local current="${COMP_WORDS[COMP_CWORD]}" at='' value='' count=0 i
  COMPREPLY=()
  for ((i = 1; i < COMP_CWORD; i++)); do
    case "${COMP_WORDS[i]}" in
      '=') ;;               # bash parts --option=value, and HOST:PORT
      ':') i=$((i + 1)) ;;
      *) _sightline_step "${COMP_WORDS[i]}" ;;
    esac
  done
  if [[ "$current" == '=' ]]; then current=''; fi

  local IFS=$'\n'
  if [[ -z "$value" ]]; then
    if [[ "$current" == -* ]]; then
      COMPREPLY=($(compgen -W "$(_sightline_options "$at" | cut -d: -f1)" -- "$current"))
      return
    fi
    COMPREPLY=($(compgen -W "$(_sightline_verbs "$at" | cut -d: -f1)" -- "$current"))
    value="$(_sightline_argument "$at" "$count")"
  fi
  case "$value" in
    file) compopt -o filenames 2>/dev/null; COMPREPLY+=($(compgen -f -- "$current")) ;;
    directory) compopt -o filenames 2>/dev/null; COMPREPLY+=($(compgen -d -- "$current")) ;;
    scene) COMPREPLY+=($(compgen -W "$(_sightline_scenes)" -- "$current")) ;;
    'choices '*) IFS=$' \n'; COMPREPLY+=($(compgen -W "${value#choices }" -- "$current")) ;;
  esac
}
complete -F _sightline sightline
)sh";

constexpr const char* kZsh = R"sh(
_sightline() {
  local at='' value='' count=0 i
  for ((i = 2; i < CURRENT; i++)); do _sightline_step "${words[i]}"; done
  if [[ -z "$value" && "$PREFIX" == --*=* ]]; then
    value="$(_sightline_value "$at" "${PREFIX%%=*}")"
    compset -P '*='
  fi

  local -a rows
  if [[ -z "$value" ]]; then
    if [[ "$PREFIX" == -* ]]; then
      rows=("${(@f)$(_sightline_options "$at")}")
      _describe -o option rows
      return
    fi
    rows=("${(@f)$(_sightline_verbs "$at")}")
    if [[ -n "$rows" ]]; then _describe verb rows; fi
    value="$(_sightline_argument "$at" "$count")"
  fi
  case "$value" in
    file) _files ;;
    directory) _files -/ ;;
    scene) compadd -- ${(f)"$(_sightline_scenes)"} ;;
    'choices '*) compadd -- ${=value#choices } ;;
  esac
}
if [[ "${zsh_eval_context[-1]}" == loadautofunc ]]; then _sightline "$@"; else compdef _sightline sightline; fi
)sh";

std::string tables(std::span<const Verb> verbs) {
  return rows_function("_sightline_verbs", verbs, verb_rows) + "\n" +
         rows_function("_sightline_options", verbs, option_rows) + "\n" + is_verb_function(verbs) +
         "\n" + option_values_function(verbs) + "\n" + arguments_function(verbs);
}

}  // namespace

std::string bash_completion(std::span<const Verb> verbs) {
  return "# Completion of sightline for bash, as `sightline completion bash` prints it.\n\n" +
         tables(verbs) + kShSteps + kBash;
}

std::string zsh_completion(std::span<const Verb> verbs) {
  return "#compdef sightline\n"
         "# Completion of sightline for zsh, as `sightline completion zsh` prints it.\n\n" +
         tables(verbs) + kShSteps + kZsh;
}

}  // namespace sightline::client::cli::reference
