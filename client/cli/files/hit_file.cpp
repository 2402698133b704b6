// Converts columns of answers to rows of a file.
#include "client/cli/files/hit_file.h"

#include <utility>

#include "client/cli/files/npy.h"

namespace sightline::client::cli::files {

Result<HitFile> HitFile::open(const std::string& path, std::vector<HitColumn> columns,
                              std::optional<std::uint64_t> rows) {
  auto output = Output::open(path);
  if (!output) return output.error();
  HitFile file(*std::move(output), std::move(columns), rows, path.ends_with(".npy"));
  if (const Status wrote = file.output_.write(file.header(rows.value_or(0))); !wrote)
    return wrote.error();
  return file;
}

std::string HitFile::header(std::uint64_t rows) const {
  if (is_npy_) {
    std::vector<NpyField> fields;
    fields.reserve(columns_.size());
    for (const HitColumn column : columns_)
      fields.push_back({info_of(column).name, info_of(column).type});
    return make_npy_header(fields, rows);
  }
  std::string names;
  for (const HitColumn column : columns_) {
    if (!names.empty()) names += ',';
    names += info_of(column).name;
  }
  return names + '\n';
}

void HitFile::add_npy_rows(const RowView& hits, std::size_t n) {
  std::size_t stride = 0;
  for (const HitColumn column : columns_) stride += info_of(column).bytes;
  buffer_.resize(n * stride);
  std::size_t offset = 0;
  for (const HitColumn column : columns_) {
    for (std::size_t i = 0; i < n; ++i)
      put_bytes(hits, i, column, buffer_.data() + i * stride + offset);
    offset += info_of(column).bytes;
  }
}

void HitFile::add_csv_rows(const RowView& hits, std::size_t n) {
  buffer_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      if (k > 0) buffer_ += ',';
      put_text(hits, i, columns_[k], buffer_);
    }
    buffer_ += '\n';
  }
}

Status HitFile::write(const RowView& hits, std::size_t n) {
  if (is_npy_) {
    add_npy_rows(hits, n);
  } else {
    add_csv_rows(hits, n);
  }
  written_ += n;
  return output_.write(buffer_);
}

Status HitFile::commit() {
  if (is_npy_ && promised_ != written_) {
    if (Status wrote = output_.write_at_start(header(written_)); !wrote) return wrote;
  }
  return output_.commit();
}

}  // namespace sightline::client::cli::files
