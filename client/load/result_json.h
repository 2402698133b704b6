// The result of a load test as a JSON document.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "client/load/load_test.h"
#include "client/load/machine.h"

namespace sightline::client::load {

using Json = nlohmann::ordered_json;

/// What was asked for, beside the options.
struct LoadContext {
  std::string rays;     ///< the kind, or the name of the file
  std::string command;  ///< as typed
  std::string client_version;
  Machine machine;
};

/// The value of --kind.
const char* name_of(QueryKind kind);

/// Keys of the whole: those of the options that a comparison needs to be fair, `rows`,
/// `crossovers`, `warnings`, `server`, `machine`.
Json to_json(const LoadOptions& options, const LoadContext& context, const LoadResult& result);

/// Where a full build before the first ray begins to pay.
struct Crossovers {
  std::optional<double> coverage;  ///< percent
  struct ByRays {
    double coverage = 0;         ///< percent, of the two rows
    std::optional<double> rays;  ///< nothing: lazy is ahead to the end
  };
  std::vector<ByRays> rays;
};
Crossovers find_crossovers(const std::vector<Row>& rows);

/// The row of that build and coverage, or null.
const Row* find_row(const std::vector<Row>& rows, BuildMode build, double coverage);

/// Whether the server builds all before the first ray in this row.
bool is_full(const Row& row, const ServerInfo& server);

}  // namespace sightline::client::load
