// Words, lines and numbers of the text formats that are read here. Internal to the importer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "client/importer/file_scene.h"

namespace sightline::client::importer::formats {

/// What may stand at the start of a text in UTF-8.
inline constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

/// The next word of the text, which is removed from it. Blanks are spaces and tabs. Empty: there is
/// none.
std::string_view take_word(std::string_view& text);

std::string_view trimmed(std::string_view text);

/// The value of a word that is a decimal number: the nearest double, or infinite if it is too
/// large. nan, inf and 1.#INF are numbers, too. Nothing: the word is no number.
std::optional<double> number(std::string_view word);

/// The value of a word that is an integer.
std::optional<std::int64_t> integer(std::string_view word);

/// `word` as messages show it: cut off if it is long, and on one line.
std::string shown(std::string_view word);

/// Why a word is no number, for a message.
std::string not_a_number(std::string_view word);

std::string in_lower_case(std::string_view text);

/// Goes through a text from its start. Lines end with LF, CR or CR LF; a byte order mark of UTF-8
/// is skipped.
class TextCursor {
 public:
  /// Continues a text whose first lines another reader has taken.
  explicit TextCursor(std::string_view text, std::size_t at = 0, std::uint64_t line = 1);

  /// The next word, on this line or a later one. Empty: the text is at its end.
  std::string_view word();
  /// The rest of this line, without its end, and goes to the next line.
  std::string_view rest_of_line();
  /// Whether another word follows on this line.
  bool has_word_on_line();

  bool is_at_end() const { return at_ == text_.size(); }
  /// Whether the last line that rest_of_line returned has an end.
  bool was_ended() const { return was_ended_; }
  std::uint64_t line() const { return line_; }  ///< from 1
  std::size_t at() const { return at_; }        ///< in bytes

 private:
  void skip_end_of_line();

  std::string_view text_;
  std::size_t at_;
  std::uint64_t line_;
  bool was_ended_ = true;
};

/// Reports how much of a file is read, now and then.
class ReadProgress {
 public:
  explicit ReadProgress(const SceneFile& file) : file_(file) {}

  void reached(std::size_t at) {
    if (at < next_) return;
    next_ = at + kStep;
    if (file_.progress)
      file_.progress(static_cast<double>(at) / static_cast<double>(file_.bytes.size()));
  }

 private:
  static constexpr std::size_t kStep = std::size_t{1} << 20;  // bytes

  const SceneFile& file_;
  std::size_t next_ = kStep;
};

}  // namespace sightline::client::importer::formats
