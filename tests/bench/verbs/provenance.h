// The program, machine and date of measurements.
#pragma once

#include <string>

namespace sightline::bench {

struct Provenance {
  std::string machine;   ///< "2 cores of AMD EPYC".
  std::string compiler;  ///< "GCC 12.2.0".
  /// The current commit of the checkout that this program was built from, followed by "+" if
  /// tracked sources have changed since. "unknown" if there is none.
  std::string commit;
  std::string date;  ///< UTC, YYYY-MM-DD.
};

Provenance provenance();

/// The checkout that this program was built from.
std::string source_folder();

}  // namespace sightline::bench
