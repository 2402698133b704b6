// A file of hits in one of the formats.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/cast_options.h"
#include "client/cli/files/hit_columns.h"
#include "client/cli/files/hit_format.h"
#include "client/cli/files/output.h"
#include "client/result.h"

namespace sightline::client::cli::files {

struct HitFileOptions {
  std::optional<Format> format = {};  ///< not set: by the suffix; CSV without one
  /// The number of rows, if it is known in advance: then .npy can go to an output that cannot be
  /// written twice.
  std::optional<std::uint64_t> rows = {};
  /// The shape of the array of rows, if it is known; empty: (rows).
  std::vector<std::uint64_t> array_shape = {};
  bool names = true;  ///< CSV begins with a line of names
  RowKind asked = RowKind::kRays;
};

class HitFile {
 public:
  /// "-" is standard output. Errors: kInvalidArgument, also for an unknown suffix.
  static Result<HitFile> open(const std::string& path, std::vector<HitColumn> columns,
                              const HitFileOptions& options = {});

  /// A file in a format of its own. `rows` as in HitFileOptions.
  static Result<HitFile> open(const std::string& path, std::unique_ptr<HitFormat> format,
                              std::optional<std::uint64_t> rows = {});

  /// Whether rows must have `lines`.
  bool needs_lines() const { return format_->needs_lines(); }

  /// Appends n rows. Nothing is written before the first call.
  Status write(const RowView& hits, std::size_t n);

  /// Completes the file. Without this call, no file is created.
  Status commit();

 private:
  HitFile(Output output, std::unique_ptr<HitFormat> format, std::optional<std::uint64_t> rows)
      : output_(std::move(output)), format_(std::move(format)), promised_(rows) {}
  Status begin();

  Output output_;
  std::unique_ptr<HitFormat> format_;
  std::optional<std::uint64_t> promised_;
  bool begun_ = false;
  std::uint64_t written_ = 0;
  std::string buffer_;
};

}  // namespace sightline::client::cli::files
