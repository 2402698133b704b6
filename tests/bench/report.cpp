// Rows of named figures.
#include "tests/bench/report.h"

#include <fmt/core.h>

#include <algorithm>

namespace sightline::bench {
namespace {

std::string cell_text(const Row& row, const std::string& key) {
  const auto found = row.find(key);
  if (found == row.end() || found->is_null()) return "-";
  if (found->is_string()) return found->get<std::string>();
  if (found->is_number_float()) return fmt::format("{:.6g}", found->get<double>());
  return found->dump();
}

}  // namespace

std::string to_json_lines(const std::vector<Row>& rows) {
  std::string text;
  for (const Row& row : rows) text += row.dump() + "\n";
  return text;
}

std::string to_table(const std::vector<Row>& rows) {
  std::vector<std::string> keys;
  for (const Row& row : rows) {
    for (const auto& [key, value] : row.items()) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
  }
  std::size_t key_width = 0;
  for (const std::string& key : keys) key_width = std::max(key_width, key.size());
  std::vector<std::size_t> widths;
  for (const Row& row : rows) {
    std::size_t width = 0;
    for (const std::string& key : keys) width = std::max(width, cell_text(row, key).size());
    widths.push_back(width);
  }
  std::string text;
  for (const std::string& key : keys) {
    text += fmt::format("{:<{}}", key, key_width);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      text += fmt::format("  {:>{}}", cell_text(rows[i], key), widths[i]);
    }
    text += '\n';
  }
  return text;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

void set_times(Row& row, const std::string& key, const std::vector<double>& values) {
  row[key] = median(values);
  row[key + "_min"] = *std::min_element(values.begin(), values.end());
}

}  // namespace sightline::bench
