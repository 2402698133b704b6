// Fills batches with the rays that are there.
#include "client/cli/files/row_reader.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

namespace sightline::client::cli::files {
namespace {

class Batches {
 public:
  explicit Batches(std::shared_ptr<RowReader> reader) : reader_(std::move(reader)) {}

  Result<bool> wait() {
    if (pending_) return true;
    return read();
  }

  Result<std::size_t> fill(const RayColumns<double>& buffer) {
    if (!pending_) {
      const auto soon = reader_->wait(kLongestPause);
      if (!soon) return soon.error();
      if (!*soon) return std::size_t{0};
    }
    for (std::size_t i = 0; i < buffer.size(); ++i) {
      const auto is_there = i == 0 || pending_ ? Result<bool>(true) : reader_->ready();
      if (!is_there) return is_there.error();
      if (!*is_there) return i;
      const auto more = pending_ ? Result<bool>(true) : read();
      if (!more) return more.error();
      if (!*more) return i;
      put(*std::exchange(pending_, std::nullopt), buffer, i);
    }
    return buffer.size();
  }

 private:
  Result<bool> read() {
    RayRow row{};
    auto more = reader_->next(row);
    if (more && *more) pending_ = row;
    return more;
  }

  static void put(const RayRow& row, const RayColumns<double>& buffer, std::size_t i) {
    const auto at = static_cast<std::ptrdiff_t>(3 * i);
    std::copy_n(row.begin(), 3, buffer.origins.begin() + at);
    if (!buffer.directions.empty()) std::copy_n(row.begin() + 3, 3, buffer.directions.begin() + at);
    if (!buffer.tmin.empty()) buffer.tmin[i] = row[6];
    if (!buffer.tmax.empty()) buffer.tmax[i] = row[7];
  }

  std::shared_ptr<RowReader> reader_;
  std::optional<RayRow> pending_;
};

}  // namespace

Result<bool> wait_for_line(Input& input, RowReader& reader, std::chrono::milliseconds longest) {
  const auto until = std::chrono::steady_clock::now() + longest;
  while (true) {
    auto is_there = reader.ready();
    if (!is_there || *is_there) return is_there;
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
    auto more = input.wait_for_more(left);
    if (!more || !*more) return more;
  }
}

LiveRays live_rays(std::shared_ptr<RowReader> reader) {
  const auto batches = std::make_shared<Batches>(std::move(reader));
  return {[batches](const RayColumns<double>& buffer) { return batches->fill(buffer); },
          [batches] { return batches->wait(); }};
}

}  // namespace sightline::client::cli::files
