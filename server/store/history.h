// Whether a database is as new as what it has acknowledged, by the marks beside it.
#pragma once

#include <string>
#include <vector>

#include "proto/result.h"
#include "server/store/database.h"
#include "server/store/head_marks.h"

namespace sightline::server::store {

/// A scene whose mark and row do not fit together.
struct HistoryFinding {
  enum class Kind : std::uint8_t {
    kCut,      ///< The row is older than the mark: what was acknowledged is lost.
    kMissing,  ///< There is no row.
    kUnknown,  ///< There is no mark, although there should be one.
  };
  Kind kind = Kind::kCut;
  SceneId scene = 0;
  std::string text;  ///< For people.
};

/// Compares all scenes. A mark may be behind its row, which is not a finding. Errors: as Database.
Result<std::vector<HistoryFinding>> compare_history(Database& database, const HeadMarks& marks);

/// Call it before the store is used. A scene that is cut is refused from now on; one whose mark is
/// not there gets new tokens, so that none of a lost history is taken; marks that are behind catch
/// up. Errors: as Database, kDataLoss (STORE_CORRUPT: scenes are missing altogether).
Status check_history(Database& database, HeadMarks& marks);

/// Goes on with what is there: scenes that were cut get new tokens, and are served; marks of
/// missing scenes go. Returns what was done, a line each. Errors: as Database, those of FileSystem.
Result<std::vector<std::string>> accept_history(Database& database, HeadMarks& marks);

}  // namespace sightline::server::store
