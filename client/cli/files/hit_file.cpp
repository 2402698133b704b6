// The header goes out with the first rows, so that a cast that fails prints nothing.
#include "client/cli/files/hit_file.h"

#include <utility>

namespace sightline::client::cli::files {

Result<HitFile> HitFile::open(const std::string& path, std::vector<HitColumn> columns,
                              const HitFileOptions& options) {
  const auto suffix = path == "-" ? std::optional<Format>() : format_of(path);
  if (!options.format && !suffix) return suffix.error();
  const Format format = options.format ? *options.format : suffix->value_or(Format::kCsv);
  return open(path,
              make_hit_format(
                  format, {std::move(columns), options.array_shape, options.names, options.asked}),
              options.rows);
}

Result<HitFile> HitFile::open(const std::string& path, std::unique_ptr<HitFormat> format,
                              std::optional<std::uint64_t> rows) {
  auto output = Output::open(path);
  if (!output) return output.error();
  return HitFile(*std::move(output), std::move(format), rows);
}

Status HitFile::begin() {
  if (std::exchange(begun_, true)) return {};
  return output_.write(format_->header(promised_.value_or(0)));
}

Status HitFile::write(const RowView& hits, std::size_t n) {
  if (Status begun = begin(); !begun) return begun;
  buffer_.clear();
  written_ += format_->add(hits, n, buffer_);
  return output_.write(buffer_);
}

Status HitFile::commit() {
  if (Status begun = begin(); !begun) return begun;
  const auto rest = format_->finish();
  if (!rest) return rest.error();
  if (Status wrote = output_.write(*rest); !wrote) return wrote;
  if (format_->counts_rows() && promised_.value_or(0) != written_) {
    if (Status wrote = output_.write_at_start(format_->header(written_)); !wrote) return wrote;
  }
  return output_.commit();
}

}  // namespace sightline::client::cli::files
