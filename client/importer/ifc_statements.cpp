// Parts the text at semicolons that stand outside of strings.
#include "client/importer/ifc_statements.h"

#include <algorithm>
#include <charconv>

#include "client/importer/formats/text.h"

namespace sightline::client::importer {

using formats::trimmed;

std::size_t find_outside(std::string_view text, char wanted, bool counts_depth) {
  bool in_string = false;
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\'') in_string = !in_string;
    if (in_string) continue;
    if (c == wanted && (depth == 0 || !counts_depth)) return i;
    if (c == '(') ++depth;
    if (c == ')') --depth;
  }
  return text.size();
}

std::uint64_t number_of(std::string_view reference) {
  if (!reference.starts_with('#')) return 0;
  std::uint64_t number = 0;
  for (const char c : reference.substr(1)) {
    if (c < '0' || c > '9') break;
    number = 10 * number + static_cast<std::uint64_t>(c - '0');
  }
  return number;
}

std::string_view take_argument(std::string_view& rest) {
  const std::size_t end = find_outside(rest, ',', true);
  const std::string_view first = trimmed(rest.substr(0, end));
  rest.remove_prefix(std::min(rest.size(), end + 1));
  return first;
}

std::string_view argument(const Statement& statement, std::size_t index) {
  std::string_view rest = statement.arguments;
  for (; index > 0 && !rest.empty(); --index) take_argument(rest);
  return take_argument(rest);
}

std::string_view inside_of(std::string_view list) {
  const bool is_list = list.starts_with('(') && list.ends_with(')');
  return is_list ? list.substr(1, list.size() - 2) : std::string_view();
}

std::array<double, 3> numbers_of(std::string_view list) {
  std::array<double, 3> out{};
  const Statement numbers{{}, inside_of(list)};
  for (std::size_t k = 0; k < out.size(); ++k) {
    const std::string_view number = argument(numbers, k);
    std::from_chars(number.data(), number.data() + number.size(), out[k]);
  }
  return out;
}

Statements::Statements(std::string_view step) {
  while (!step.empty()) {
    const std::size_t end = find_outside(step, ';', false);
    add(trimmed(step.substr(0, end)));
    step.remove_prefix(std::min(step.size(), end + 1));
  }
}

std::vector<std::uint64_t> Statements::loose_ends() const {
  std::vector<std::uint64_t> out = repeated_;
  for (const auto& [number, statement] : all_) {
    std::string_view rest = statement.arguments;
    for (std::size_t at = find_outside(rest, '#', false); at < rest.size();
         at = find_outside(rest, '#', false)) {
      rest.remove_prefix(at);
      const std::uint64_t named = number_of(rest);
      if (!all_.contains(named)) out.push_back(named);
      rest.remove_prefix(1);
    }
  }
  return out;
}

const Statement* Statements::find(std::string_view reference) const {
  const auto found = all_.find(number_of(reference));
  return found == all_.end() ? nullptr : &found->second;
}

void Statements::add(std::string_view text) {
  // A string that is not closed goes on to the next quote, over other statements.
  for (std::size_t line = text.find("\n#"); line != text.npos; line = text.find("\n#", line + 1)) {
    const std::size_t end = text.find_first_not_of("0123456789", line + 2);
    if (end != text.npos && trimmed(text.substr(end, text.find('(', end) - end)).starts_with('='))
      repeated_.push_back(number_of(text.substr(line + 1)));
  }
  const std::uint64_t number = number_of(text);
  const std::size_t equals = text.find('='), open = text.find('(');
  if (number == 0 || equals >= open || open == text.npos || !text.ends_with(')')) return;
  if (all_.contains(number)) repeated_.push_back(number);
  all_[number] = {trimmed(text.substr(equals + 1, open - equals - 1)),
                  text.substr(open + 1, text.size() - open - 2)};
}

}  // namespace sightline::client::importer
