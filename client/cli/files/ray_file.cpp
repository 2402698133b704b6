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

Result<RayTable> parse_npy(FileBytes file) {
  const auto array = parse_npy_array(file);
  if (!array) return array.error();
  return table_of(*array);
}

constexpr const char* kNpzNames =
    "`rays`, or `origins` and `directions` and, if you like, `tmin` and `tmax`";

Result<RayTable> parse_npz(FileBytes file) {
  auto unzipped = unzip(file);
  if (!unzipped) return unzipped.error();
  const auto parts =
      std::make_shared<std::map<std::string, std::vector<std::byte>>>(*std::move(unzipped));
  std::map<std::string, NpyArray> arrays;
  for (const auto& [name, bytes] : *parts) {
    auto array = parse_npy_array(bytes);
    if (!array) return local_error(fmt::format("{}: {}", name, array.error().message));
    arrays.emplace(name, *std::move(array));
  }
  const auto find = [&](const char* name) {
    const auto found = arrays.find(std::string(name) + ".npy");
    return found == arrays.end() ? nullptr : &found->second;
  };
  const NpyArray* const whole = arrays.size() == 1 ? &arrays.begin()->second : find("rays");
  const NpyArray* const origins = find("origins");
  const NpyArray* const directions = find("directions");
  if (whole == nullptr && (origins == nullptr || directions == nullptr))
    return local_error(fmt::format("has no arrays of rays: {}", kNpzNames));
  auto table = whole != nullptr ? table_of(*whole)
                                : table_of(*origins, *directions, find("tmin"), find("tmax"));
  if (table) table->owners.emplace_back(parts);
  return table;
}

Result<RayFile> open_table(Input opened, Result<RayTable> (*parse)(FileBytes)) {
  const auto input = std::make_shared<Input>(std::move(opened));
  const auto bytes = input->whole();
  if (!bytes) return bytes.error();
  auto parsed = parse(*bytes);
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

Result<RayFile> open_csv(Input input) {
  auto opened = CsvRays::open(std::move(input));
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
  const auto suffix = path == "-" ? std::optional<Format>() : format_of(path);
  if (!suffix) return suffix.error();
  auto input = Input::open(path, std::move(stop));
  if (!input) return input.error();
  const auto format = tell(*input, *suffix);
  if (!format) return format.error();
  switch (*format) {
    case Format::kNpy:
      return open_table(*std::move(input), parse_npy);
    case Format::kNpz:
      return open_table(*std::move(input), parse_npz);
    case Format::kPly:
      return open_table(*std::move(input), parse_ply_rays);
    case Format::kNdjson:
      return live_ray_file(std::make_shared<JsonRays>(*std::move(input)), true);
    case Format::kCsv:
      break;
  }
  return open_csv(*std::move(input));
}

}  // namespace sightline::client::cli::files
