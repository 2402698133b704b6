// The trace that a call belongs to: W3C Trace Context, header traceparent.
#include "server/exec/trace_context.h"

#include <algorithm>
#include <cstddef>

namespace sightline::server::exec {
namespace {

// VERSION-TRACE_ID-PARENT_ID-FLAGS, each field in small hexadecimal digits.
constexpr std::size_t kTraceAt = 3, kTraceDigits = 32;
constexpr std::size_t kParentAt = 36, kParentDigits = 16;
constexpr std::size_t kFlagsAt = 53, kLength = 55;

bool is_hex(std::string_view text) {
  return text.find_first_not_of("0123456789abcdef") == text.npos;
}

/// All zeros stand for no id.
bool is_id(std::string_view text) {
  return is_hex(text) && text.find_first_not_of('0') != text.npos;
}

/// Without the blanks that may surround the value of a header (RFC 9110).
std::string_view trim(std::string_view text) {
  constexpr std::string_view kBlanks = " \t";
  const std::size_t begin = std::min(text.find_first_not_of(kBlanks), text.size());
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

}  // namespace

std::string_view parse_trace_id(std::string_view traceparent) {
  const std::string_view text = trim(traceparent);
  if (text.size() < kLength) return {};
  const std::string_view version = text.substr(0, 2);
  if (!is_hex(version) || version == "ff") return {};
  // A later version may add fields behind the four; version 00 has no more.
  const std::string_view more = text.substr(kLength);
  if (!more.empty() && (version == "00" || more.front() != '-')) return {};
  if (text[kTraceAt - 1] != '-' || text[kParentAt - 1] != '-' || text[kFlagsAt - 1] != '-')
    return {};
  const std::string_view trace = text.substr(kTraceAt, kTraceDigits);
  const bool is_good = is_id(trace) && is_id(text.substr(kParentAt, kParentDigits)) &&
                       is_hex(text.substr(kFlagsAt, kLength - kFlagsAt));
  return is_good ? trace : std::string_view();
}

}  // namespace sightline::server::exec
