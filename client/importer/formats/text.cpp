// Numbers are read by std::from_chars, which rounds correctly and knows no language.
#include "client/importer/formats/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <system_error>

namespace sightline::client::importer::formats {
namespace {

constexpr std::size_t kShown = 40;  // characters of a word or line

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool is_end_of_line(char c) { return c == '\n' || c == '\r'; }

std::string_view without_plus(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  return word;
}

// What Microsoft's libraries print: 1.#INF, -1.#INF00, 1.#QNAN, -1.#IND.
std::optional<double> special_of_microsoft(std::string_view word) {
  const bool is_negative = word.starts_with('-');
  if (is_negative) word.remove_prefix(1);
  if (!word.starts_with("1.#")) return {};
  word.remove_prefix(3);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (word.starts_with("INF")) return is_negative ? -kInfinity : kInfinity;
  if (word.starts_with("QNAN") || word.starts_with("SNAN") || word.starts_with("IND"))
    return std::numeric_limits<double>::quiet_NaN();
  return {};
}

}  // namespace

std::string_view take_word(std::string_view& text) {
  std::size_t begin = 0;
  while (begin < text.size() && is_blank(text[begin])) ++begin;
  std::size_t end = begin;
  while (end < text.size() && !is_blank(text[end])) ++end;
  const std::string_view word = text.substr(begin, end - begin);
  text.remove_prefix(end);
  return word;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kWhiteSpace = " \t\v\f\r\n";
  const std::size_t first = text.find_first_not_of(kWhiteSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kWhiteSpace) + 1 - first);
}

std::optional<double> number(std::string_view word) {
  const std::string_view digits = without_plus(word);
  const char* const end = digits.data() + digits.size();
  double value = 0;
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  if (error == std::errc{} && stop == end) return value;
  // It is too large or too small for a double.
  if (error == std::errc::result_out_of_range && stop == end)
    return std::strtod(std::string(digits).c_str(), nullptr);
  return special_of_microsoft(digits);
}

std::optional<std::int64_t> integer(std::string_view word) {
  const std::string_view digits = without_plus(word);
  const char* const end = digits.data() + digits.size();
  std::int64_t value = 0;
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  if (error == std::errc{} && stop == end) return value;
  return {};
}

std::string shown(std::string_view word) {
  std::string text(word.substr(0, kShown));
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; }, '?');
  return word.size() > kShown ? text + "..." : text;
}

std::string not_a_number(std::string_view word) {
  if (word.find(',') == std::string_view::npos)
    return fmt::format("'{}' is no number", shown(word));
  return fmt::format("'{}' is no number; the decimal sign is a point, and blanks part numbers",
                     shown(word));
}

std::string in_lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

TextCursor::TextCursor(std::string_view text, std::size_t at, std::uint64_t line)
    : text_(text), at_(at), line_(line) {
  if (at_ == 0 && text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
}

std::string_view TextCursor::word() {
  while (at_ < text_.size()) {
    if (is_end_of_line(text_[at_])) {
      skip_end_of_line();
    } else if (is_blank(text_[at_])) {
      ++at_;
    } else {
      break;
    }
  }
  const std::size_t begin = at_;
  while (at_ < text_.size() && !is_blank(text_[at_]) && !is_end_of_line(text_[at_])) ++at_;
  return text_.substr(begin, at_ - begin);
}

std::string_view TextCursor::rest_of_line() {
  const std::size_t begin = at_;
  while (at_ < text_.size() && !is_end_of_line(text_[at_])) ++at_;
  const std::string_view rest = text_.substr(begin, at_ - begin);
  was_ended_ = at_ < text_.size();
  if (was_ended_) skip_end_of_line();
  return rest;
}

bool TextCursor::has_word_on_line() {
  while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
  return at_ < text_.size() && !is_end_of_line(text_[at_]);
}

void TextCursor::skip_end_of_line() {
  const bool is_pair = text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n';
  at_ += is_pair ? 2 : 1;
  ++line_;
}

}  // namespace sightline::client::importer::formats
