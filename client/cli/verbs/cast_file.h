// Casts the rays of a file, and writes what they hit to another; or the points of a file, and what
// is nearest to them.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "client/cli/files/format.h"
#include "client/cli/files/hit_columns.h"
#include "client/cli/files/hit_file.h"
#include "client/cli/files/ray_file.h"
#include "client/cli/verbs/ray_watch.h"
#include "client/client.h"

namespace sightline::client::cli::verbs {

struct CastFileRequest {
  std::string scene;
  std::string in;
  std::string out;
  std::vector<files::HitColumn> columns;
  std::optional<files::Format> out_format;  ///< not set: by the suffix of `out`
  bool names = true;                        ///< CSV begins with a line of names
  CastOptions options;
  files::RowKind asked = files::RowKind::kRays;
  std::optional<double> max_distance{};  ///< of points
  /// Applied when the files are open; the revision that they make answers.
  std::optional<std::vector<Update>> updates{};
};

/// What is asked about rays that are open already.
struct CastRequest {
  std::string scene;
  HitFields fields;
  CastOptions options;
  files::RowKind asked = files::RowKind::kRays;
  std::optional<double> max_distance{};  ///< of points
};

struct CastOutcome {
  files::RowKind asked = files::RowKind::kRays;
  CastReport cast;
  std::optional<Applied> applied{};       ///< what updates of the request came to
  bool looks_for_faces = true;            ///< otherwise `hits` of the cast are none
  std::optional<std::uint64_t> inside{};  ///< the points that are, if `inside` was asked
  double seconds = 0;
  float float_reach = 0;  ///< the largest coordinate of the origins, if the file has float32
  RayWatch watch;
};

/// Rays that come line by line are cast as they come, and answered before more are waited for;
/// after a pause of files::kLongestPause the newest revision answers. Nothing is written, and no
/// file is made, if an error comes before the first answer. Errors: those of the files and of the
/// calls.
Result<CastOutcome> cast_file(const Client& client, const CastFileRequest& request);

/// Casts as cast_file() does, from and to what is open.
Result<CastOutcome> cast_rays(const Client& client, CastRequest request, files::RayFile rays,
                              files::HitFile hits);

/// Adds what a part of a cast has cost.
void add(const CastReport& part, CastReport& sum);

}  // namespace sightline::client::cli::verbs
