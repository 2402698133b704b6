// Writes roff.
#include "client/cli/reference/manual.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string_view>

#include "client/cli/reference/verb.h"

namespace sightline::client::cli::reference {
namespace {

constexpr std::string_view kExamples = "Examples:\n";

/// Text without meaning to roff. A dash is the character that is typed, not a hyphen.
std::string roff(std::string_view text) {
  std::string out;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
    line_begins = c == '\n';
  }
  return out;
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string dashed(std::string text) {
  for (char& c : text) {
    if (c == ' ') c = '-';
  }
  return text;
}

/// Lines that begin with a blank keep their layout, others are filled.
std::string prose(std::string_view text) {
  std::string out;
  bool kept = false;
  const auto keep = [&out, &kept](bool wanted) {
    if (kept != wanted) out += wanted ? ".nf\n" : ".fi\n";
    kept = wanted;
  };
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty()) {
      keep(false);
      out += ".PP\n";
      continue;
    }
    keep(line.front() == ' ');
    out += roff(line) + "\n";
  }
  keep(false);
  return out;
}

/// What is typed of an option, with its value.
std::string term(const Option& option, bool is_argument) {
  std::string out;
  for (const std::string& name : option.names) {
    if (!out.empty()) out += ", ";
    out += fmt::format("{}{}\\fR", is_argument ? "\\fI" : "\\fB", roff(name));
  }
  if (!is_argument && !option.label.empty()) out += " \\fI" + roff(option.label) + "\\fR";
  if (option.repeated) out += " ...";
  return out;
}

std::string section_of(const std::string& title, const std::vector<Option>& options,
                       bool are_arguments) {
  if (options.empty()) return "";
  std::string out = ".SH " + title + "\n";
  for (const Option& option : options) {
    out += ".TP\n" + term(option, are_arguments) + "\n" + roff(option.help);
    if (option.required && !are_arguments) out += ". Required";
    out += ".\n";
  }
  return out;
}

std::string synopsis(const std::string& command, const Verb& verb) {
  std::string out = ".SH SYNOPSIS\n\\fB" + roff(command) + "\\fR [\\fIOPTION\\fR ...]";
  for (const Option& argument : verb.arguments) {
    const std::string name = "\\fI" + roff(argument.names.front()) + "\\fR";
    out += argument.required ? " " + name : " [" + name + "]";
  }
  if (!verb.verbs.empty()) out += " \\fIVERB\\fR";
  return out + "\n";
}

/// The verbs below `verb`, each with the page that it has.
std::string below(const std::string& program, int section, const Verb& verb,
                  const std::vector<Verb>& verbs) {
  if (verb.verbs.empty()) return "";
  std::string out = ".SH VERBS\n";
  for (const Verb& other : verbs) {
    if (other.path.empty() || join_path(verb.path, name_of(other)) != other.path) continue;
    const std::string page = dashed(join_path(program, other.path));
    out += fmt::format(".TP\n\\fB{}\\fR({})\n{}.\n", roff(page), section, roff(other.summary));
  }
  return out;
}

std::string details_of(const Verb& verb) {
  const std::size_t split = verb.details.find(kExamples);
  const std::string text = verb.details.substr(0, split);
  std::string out;
  if (text.find_first_not_of('\n') != std::string::npos) {
    out += ".SH DESCRIPTION\n" + prose(text.substr(0, text.find_last_not_of('\n') + 1));
  }
  if (split != std::string::npos)
    out += ".SH EXAMPLES\n" + prose(verb.details.substr(split + kExamples.size()));
  return out;
}

std::string see_also(const std::string& program, int section, const Verb& verb) {
  if (verb.path.empty()) return "";
  return fmt::format(".SH SEE ALSO\n\\fB{}\\fR({}), for the options that every verb takes\n",
                     roff(program), section);
}

}  // namespace

std::vector<ManualPage> manual_of(const CLI::App& program, int section, const std::string& source) {
  const std::string& name = program.get_name();
  const std::vector<Verb> verbs = verbs_of(program);
  std::vector<ManualPage> pages;
  for (const Verb& verb : verbs) {
    const std::string command = verb.path.empty() ? name : name + " " + verb.path;
    const std::string page = dashed(command);
    std::string text = fmt::format(".TH {} {} \"\" \"{}\" \"Sightline\"\n", roff(upper(page)),
                                   section, roff(source));
    text += fmt::format(".SH NAME\n{} \\- {}\n", roff(page), roff(verb.summary));
    text += synopsis(command, verb) + section_of("ARGUMENTS", verb.arguments, true) +
            section_of("OPTIONS", verb.options, false) + below(name, section, verb, verbs) +
            details_of(verb) + see_also(name, section, verb);
    pages.push_back({fmt::format("{}.{}", page, section), std::move(text)});
  }
  return pages;
}

}  // namespace sightline::client::cli::reference
