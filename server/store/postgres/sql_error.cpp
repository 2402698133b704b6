// The errors of PostgreSQL. Each names the database and what to do about it.
#include "server/store/postgres/sql_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

namespace sightline::server::store::postgres {
namespace {

/// libpq ends its messages with new lines, and has more of them with tabs within.
std::string one_line(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool is_space = c == '\n' || c == '\t' || c == ' ';
    if (!is_space) {
      line += c;
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
  }
  if (line.ends_with(' ')) line.pop_back();
  return line;
}

template <std::size_t N>
bool is_one_of(std::string_view state, const std::array<std::string_view, N>& states) {
  return std::ranges::any_of(states, [&](std::string_view one) { return state.starts_with(one); });
}

// A state, or the class of states that begin like that: appendix A of PostgreSQL's manual.
constexpr std::array<std::string_view, 6> kEnding{"08",    "25006", "25P03",
                                                  "57P01", "57P02", "57P03"};
constexpr std::array<std::string_view, 3> kConflict{"40001", "40P01", "55P03"};
constexpr std::array<std::string_view, 3> kBusy{"53", "57", "58"};

}  // namespace

Error unreachable(std::string_view database, std::string_view why) {
  return {Code::kUnavailable,
          fmt::format("cannot reach a server that takes writes at {}: {}; look at PostgreSQL and "
                      "its log",
                      database, one_line(why)),
          "STORE_IO"};
}

Error damaged(std::string_view database, std::string_view what) {
  return {Code::kDataLoss,
          fmt::format("{} is damaged: {}; restore a backup", database, one_line(what)),
          "STORE_CORRUPT"};
}

Error sql_error(std::string_view database, std::string_view state, std::string_view message) {
  const std::string text = fmt::format("{}: {} ({})", database, one_line(message), state);
  if (state == "53100") {
    return {Code::kResourceExhausted,
            text + "; free space on the disk of PostgreSQL, or remove scenes", "DISK_FULL"};
  }
  if (state == "42501") {
    return {Code::kFailedPrecondition, text + "; let the user own the database", "STORE_READ_ONLY"};
  }
  if (state == "53200") return {Code::kResourceExhausted, text, "OUT_OF_MEMORY"};
  if (state.starts_with("23")) return {Code::kAborted, text, "CONSTRAINT"};
  if (state == "XX001" || state == "XX002") return damaged(database, message);
  if (is_one_of(state, kConflict)) return {Code::kUnavailable, text, "STORE_CONFLICT"};
  if (is_one_of(state, kBusy))
    return {Code::kUnavailable, text + "; look at PostgreSQL and its log", "STORE_IO"};
  return {Code::kInternal, text, "UNEXPECTED"};
}

bool ends_connection(std::string_view state) { return is_one_of(state, kEnding); }

}  // namespace sightline::server::store::postgres
