// A file of hits: .npy with a structured type, or CSV.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/cast_options.h"
#include "client/cli/files/hit_columns.h"
#include "client/cli/files/output.h"
#include "client/result.h"

namespace sightline::client::cli::files {

class HitFile {
 public:
  /// Writes .npy if the path ends in .npy, else CSV with a line of names. "-" is standard output.
  /// If the number of rows is known in advance, `rows` holds it: then .npy can go to an output that
  /// cannot be written twice. Errors: kInvalidArgument.
  static Result<HitFile> open(const std::string& path, std::vector<HitColumn> columns,
                              std::optional<std::uint64_t> rows);

  /// Appends n rows.
  Status write(const RowView& hits, std::size_t n);

  /// Completes the file. Without this call, no file is created.
  Status commit();

 private:
  HitFile(Output output, std::vector<HitColumn> columns, std::optional<std::uint64_t> rows,
          bool is_npy)
      : output_(std::move(output)),
        columns_(std::move(columns)),
        promised_(rows),
        is_npy_(is_npy) {}
  std::string header(std::uint64_t rows) const;
  void add_npy_rows(const RowView& hits, std::size_t n);
  void add_csv_rows(const RowView& hits, std::size_t n);

  Output output_;
  std::vector<HitColumn> columns_;
  std::optional<std::uint64_t> promised_;
  bool is_npy_ = false;
  std::uint64_t written_ = 0;
  std::string buffer_;
};

}  // namespace sightline::client::cli::files
