// What measurements were made by, on and when.
#pragma once

#include <string>

namespace sightline::bench {

struct Provenance {
  std::string machine;   ///< "2 cores of AMD EPYC".
  std::string compiler;  ///< "GCC 12.2.0".
  /// Of the checkout that this program was built from, as it is now; "+" behind it where tracked
  /// sources have changed since. "unknown" where there is none.
  std::string commit;
  std::string date;  ///< UTC, YYYY-MM-DD.
};

Provenance provenance();

/// Where this program was built from.
std::string source_folder();

}  // namespace sightline::bench
