// Tells the format by the first bytes.
#include "client/cli/files/ray_file.h"

#include <fmt/format.h>

#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <utility>

#include "client/cli/files/csv.h"
#include "client/cli/files/format.h"
#include "client/cli/files/input.h"
#include "client/cli/files/json_rays.h"
#include "client/cli/files/npy.h"
#include "client/cli/files/ply_rays.h"
#include "client/cli/files/ray_table.h"
#include "client/cli/files/row_reader.h"
#include "client/cli/files/zip.h"
#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

using FileBytes = std::span<const std::byte>;

Result<RayTable> parse_npy(FileBytes file, RowKind kind) {
  const auto array = parse_npy_array(file, kind);
  if (!array) return array.error();
  return table_of(*array, kind);
}

/// The arrays of an archive, by name.
class NamedArrays {
 public:
  void add(std::string name, NpyArray array) { arrays_.emplace(std::move(name), std::move(array)); }

  /// Null: it is not there.
  const NpyArray* find(const char* name) const {
    const auto found = arrays_.find(std::string(name) + ".npy");
    return found == arrays_.end() ? nullptr : &found->second;
  }
  /// The only array, whatever its name is, or that of this name.
  const NpyArray* find_whole(const char* name) const {
    return arrays_.size() == 1 ? &arrays_.begin()->second : find(name);
  }

 private:
  std::map<std::string, NpyArray> arrays_;
};

Result<RayTable> table_of_rays(const NamedArrays& arrays) {
  if (const NpyArray* const rays = arrays.find_whole("rays")) return table_of(*rays);
  const NpyArray* const origins = arrays.find("origins");
  const NpyArray* const directions = arrays.find("directions");
  if (origins == nullptr || directions == nullptr) {
    return local_error(
        "has no arrays of rays: `rays`, or `origins` and `directions` and, if you like, `tmin` and "
        "`tmax`");
  }
  return table_of(*origins, *directions, arrays.find("tmin"), arrays.find("tmax"));
}

Result<RayTable> table_of_points(const NamedArrays& arrays) {
  if (const NpyArray* const points = arrays.find_whole("points"))
    return table_of(*points, RowKind::kPoints);
  const NpyArray* const positions = arrays.find("positions");
  if (positions == nullptr) {
    return local_error("has no arrays of points: `points`, or `positions` and, if you like, `max`");
  }
  return files::table_of_points(*positions, arrays.find("max"));
}

Result<RayTable> parse_npz(FileBytes file, RowKind kind) {
  auto unzipped = unzip(file);
  if (!unzipped) return unzipped.error();
  const auto parts =
      std::make_shared<std::map<std::string, std::vector<std::byte>>>(*std::move(unzipped));
  NamedArrays arrays;
  for (const auto& [name, bytes] : *parts) {
    auto array = parse_npy_array(bytes, kind);
    if (!array) return local_error(fmt::format("{}: {}", name, array.error().message));
    arrays.add(name, *std::move(array));
  }
  auto table = kind == RowKind::kRays ? table_of_rays(arrays) : table_of_points(arrays);
  if (table) table->owners.emplace_back(parts);
  return table;
}

Result<RayFile> open_table(Input opened, RowKind kind,
                           Result<RayTable> (*parse)(FileBytes, RowKind)) {
  const auto input = std::make_shared<Input>(std::move(opened));
  const auto bytes = input->whole();
  if (!bytes) return bytes.error();
  auto parsed = parse(*bytes, kind);
  if (!parsed) return local_error(fmt::format("{}: {}", input->name(), parsed.error().message));
  parsed->owners.emplace_back(input);
  const auto table = std::make_shared<const RayTable>(*std::move(parsed));
  RayFile file{source_of<double>(table),
               {.interval = table->has_interval(), .masks = false},
               table->rows(),
               table->shape};
  if (table->is_float32()) file.source = source_of<float>(table);
  return file;
}

Result<RayFile> open_csv(Input input, RowKind kind) {
  auto opened = CsvRays::open(std::move(input), kind);
  if (!opened) return opened.error();
  const auto rays = std::make_shared<CsvRays>(*std::move(opened));
  return live_ray_file(rays, rays->has_interval());
}

// What the first bytes say. Without a sign of its own the text is CSV.
Result<Format> tell(Input& input, const std::optional<Format>& suffix) {
  auto start = input.peek(1);
  if (!start) return start.error();
  const char first = start->empty() ? '\0' : start->front();
  if (first == '{' || first == '[') return Format::kNdjson;
  for (const auto& [magic, format] :
       {std::pair(kNpyMagic, Format::kNpy), std::pair(kZipMagic, Format::kNpz),
        std::pair(kPlyMagic, Format::kPly)}) {
    // More than a byte is only waited for if the first one fits.
    if (first != magic.front()) continue;
    start = input.peek(magic.size());
    if (!start) return start.error();
    if (*start == magic) return format;
  }
  return suffix.value_or(Format::kCsv);
}

}  // namespace

RayFile live_ray_file(std::shared_ptr<RowReader> reader, bool has_interval) {
  LiveRays live = live_rays(std::move(reader));
  RayFile file{
      std::move(live.source), {.interval = has_interval, .masks = false}, std::nullopt, {}};
  file.wait = std::move(live.wait);
  return file;
}

void wait_out_pauses(RayFile& file) {
  if (!file.wait) return;
  file.source =
      RaySource<double>([source = std::get<RaySource<double>>(file.source), wait = file.wait](
                            const RayColumns<double>& buffer) -> Result<std::size_t> {
        while (true) {
          auto rows = source(buffer);
          if (!rows || *rows > 0) return rows;
          const auto more = wait();
          if (!more) return more.error();
          if (!*more) return std::size_t{0};
        }
      });
  file.wait = {};
}

Result<RayFile> open_rays(const std::string& path, std::stop_token stop) {
  return open_rows(path, RowKind::kRays, std::move(stop));
}

Result<RayFile> open_points(const std::string& path, std::stop_token stop) {
  return open_rows(path, RowKind::kPoints, std::move(stop));
}

Result<RayFile> open_rows(const std::string& path, RowKind kind, std::stop_token stop) {
  const auto suffix = path == "-" ? std::optional<Format>() : format_of(path);
  if (!suffix) return suffix.error();
  auto input = Input::open(path, std::move(stop));
  if (!input) return input.error();
  const auto format = tell(*input, *suffix);
  if (!format) return format.error();
  switch (*format) {
    case Format::kNpy:
      return open_table(*std::move(input), kind, parse_npy);
    case Format::kNpz:
      return open_table(*std::move(input), kind, parse_npz);
    case Format::kPly:
      return open_table(*std::move(input), kind, parse_ply_rays);
    case Format::kNdjson:
      return live_ray_file(std::make_shared<JsonRays>(*std::move(input), kind), true);
    case Format::kCsv:
      break;
  }
  return open_csv(*std::move(input), kind);
}

}  // namespace sightline::client::cli::files
