// The values after the header of a PLY file, in text or in binary. Internal to the importer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "client/importer/formats/ply_header.h"
#include "client/importer/formats/text.h"
#include "client/result.h"

namespace sightline::client::importer::formats {

/// Reads values one after the other. A value that is not there, or is no number, ends it: all later
/// calls fail, too, and `error` says why.
class PlyValues {
 public:
  PlyValues(std::string_view file, const PlyHeader& header);

  bool next(PlyType type, double& value);
  /// The number of a list's values; they are there, if the format is binary.
  bool next_length(const PlyProperty& list, std::uint64_t& length);
  bool skip(const PlyProperty& property);
  /// Tells that an element is read as a whole. In text, the next one begins a line, as a rule.
  void end_element();
  /// Whether this many elements without lists are there, if the format is binary.
  bool has(const PlyElement& element);

  Error error() const;
  std::size_t at() const { return is_ascii() ? text_.at() : at_; }  ///< in bytes
  /// What follows the last element. Errors: kInvalidArgument: text with lines that have more
  /// values than their elements have properties.
  Result<std::uint64_t> surplus_bytes();
  /// The first line of a text on which an element begins after another; 0: there is none. Text
  /// may be broken anywhere, or a value may be missing or too many.
  std::uint64_t long_line() const { return long_line_; }

 private:
  bool is_ascii() const { return format_ == PlyFormat::kAscii; }
  bool require(std::uint64_t count, std::uint64_t bytes);
  bool next_word(double& value);

  std::string_view file_;
  PlyFormat format_;
  std::size_t at_;   // in a binary file
  TextCursor text_;  // in a text
  std::uint64_t missing_ = 0;
  std::uint64_t long_line_ = 0;
  std::string bad_;
};

}  // namespace sightline::client::importer::formats
