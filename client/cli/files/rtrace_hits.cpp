// Collects the numbers of a record, then writes them as text or bytes.
#include "client/cli/files/rtrace_hits.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

constexpr std::string_view kLetters = "odpnNlLs";
constexpr double kNoHit = 1e10;
using Triple = std::array<double, 3>;

bool is_name(char letter) { return letter == 's'; }
bool is_distance(char letter) { return letter == 'l' || letter == 'L'; }

double length_of(const Triple& v) { return std::hypot(v[0], v[1], v[2]); }

// A name is one word.
std::string word_of(const std::string& name) {
  std::string word = printable(name);
  std::replace(word.begin(), word.end(), ' ', '_');
  return word.empty() ? "*" : word;
}

class RtraceHits : public HitFormat {
 public:
  explicit RtraceHits(RtraceHitOptions options) : options_(std::move(options)) {
    for (auto& [id, name] : options_.names) name = word_of(name);
  }

  std::string header(std::uint64_t) const override {
    std::string text = options_.header ? lines_of_header() : "";
    const auto [width, height] = options_.size;
    if (width > 0 && height > 0) text += fmt::format("-Y {} +X {}\n", height, width);
    return text;
  }

  bool needs_lines() const override { return true; }

  std::size_t add(const RowView& rows, std::size_t n, std::string& bytes) override {
    for (std::size_t i = 0; i < n; ++i) {
      for (const char letter : options_.letters) add_letter(rows, i, letter, bytes);
      if (options_.numbers == RtraceNumbers::kText) bytes += '\n';
    }
    return n;
  }

 private:
  std::string lines_of_header() const {
    std::size_t numbers = 0;
    for (const char letter : options_.letters) {
      if (!is_name(letter)) numbers += is_distance(letter) ? 1 : 3;
    }
    const bool is_text = options_.numbers == RtraceNumbers::kText;
    const char* const format = is_text                                     ? "ascii"
                               : options_.numbers == RtraceNumbers::kFloat ? "float"
                                                                           : "double";
    return fmt::format("#?RADIANCE\n{}\nSOFTWARE= sightline {}\nNCOMP={}\n{}FORMAT={}\n\n",
                       options_.command, SIGHTLINE_VERSION, numbers, is_text ? "" : "BigEndian=0\n",
                       format);
  }

  void add_letter(const RowView& rows, std::size_t i, char letter, std::string& bytes) const {
    const bool is_hit = std::isfinite(rows.t[i]);
    const Triple direction = triple(rows.lines, 6 * i + 3);
    if (is_name(letter)) {
      const auto found = is_hit ? options_.names.find(rows.node[i]) : options_.names.end();
      bytes += found == options_.names.end() ? "*" : found->second;
      bytes += '\t';
    } else if (is_distance(letter)) {
      add_number(is_hit ? rows.t[i] * length_of(direction) : kNoHit, bytes);
    } else if (letter == 'o') {
      add_triple(triple(rows.lines, 6 * i), bytes);
    } else if (letter == 'd') {
      add_triple(unit(direction), bytes);
    } else if (letter == 'p') {
      add_triple(is_hit ? hit_point(rows, i) : Triple{}, bytes);
    } else {
      add_triple(is_hit ? triple(rows.normal, 3 * i) : Triple{}, bytes);
    }
  }

  template <class Number>
  static Triple triple(std::span<const Number> numbers, std::size_t at) {
    return {static_cast<double>(numbers[at]), static_cast<double>(numbers[at + 1]),
            static_cast<double>(numbers[at + 2])};
  }

  static Triple unit(const Triple& v) {
    const double length = length_of(v);
    if (!(length > 0) || !std::isfinite(length)) return {};
    return {v[0] / length, v[1] / length, v[2] / length};
  }

  void add_triple(const Triple& v, std::string& bytes) const {
    for (const double number : v) add_number(number, bytes);
  }

  void add_number(double number, std::string& bytes) const {
    if (options_.numbers == RtraceNumbers::kText) {
      fmt::format_to(std::back_inserter(bytes), "{:e}\t", number);
    } else if (options_.numbers == RtraceNumbers::kFloat) {
      add_bytes(static_cast<float>(number), bytes);
    } else {
      add_bytes(number, bytes);
    }
  }

  template <class Number>
  static void add_bytes(Number number, std::string& bytes) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
  }

  RtraceHitOptions options_;
};

}  // namespace

Status check_rtrace_letters(std::string_view letters) {
  if (letters.empty()) return local_error("there are no letters");
  for (const char letter : letters) {
    if (kLetters.find(letter) != std::string_view::npos) continue;
    const bool is_of_light = std::string_view("vVwWrRxXmMc").find(letter) != std::string_view::npos;
    return local_error(fmt::format(
        "letter '{}' is {}; known are {}", letter,
        is_of_light ? "about light or materials, which scenes do not have" : "not known",
        kLetters));
  }
  return {};
}

HitFields rtrace_fields(std::string_view letters) {
  HitFields fields{.t = true};
  for (const char letter : letters) {
    if (letter == 'n' || letter == 'N') fields.normal = true;
    if (is_name(letter)) fields.node = true;
  }
  return fields;
}

std::unique_ptr<HitFormat> make_rtrace_hits(RtraceHitOptions options) {
  return std::make_unique<RtraceHits>(std::move(options));
}

}  // namespace sightline::client::cli::files
