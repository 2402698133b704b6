// A reader of words and a reader of bytes.
#include "client/cli/files/rtrace_rays.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <deque>
#include <limits>
#include <string>
#include <utility>

#include "client/cli/flags.h"
#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

constexpr std::size_t kNumbersOfRay = 6;

class RtraceReader : public RowReader {
 public:
  RtraceReader(Input input, const RtraceRayOptions& options)
      : input_(std::move(input)), options_(options) {}

  Result<bool> next(RayRow& row) override {
    if (is_done()) return false;
    row[6] = 0;
    row[7] = options_.ends_at_direction ? 1 : std::numeric_limits<double>::infinity();
    auto more = read(row);
    if (more && *more) ++read_;
    return more;
  }

  Result<bool> ready() override { return is_done() ? Result<bool>(true) : is_there(); }

  Result<bool> wait(std::chrono::milliseconds longest) override {
    return wait_for_line(input_, *this, longest);
  }

 protected:
  /// Reads the next six numbers. False: there are none.
  virtual Result<bool> read(RayRow& row) = 0;
  /// Whether read() would not wait.
  virtual Result<bool> is_there() = 0;

  Input& input() { return input_; }
  Error cut_off() const {
    return local_error(fmt::format("{}: ends within ray {}", input_.name(), read_));
  }

 private:
  bool is_done() const { return options_.count && read_ >= *options_.count; }

  Input input_;
  RtraceRayOptions options_;
  std::uint64_t read_ = 0;
};

class TextRays : public RtraceReader {
 public:
  using RtraceReader::RtraceReader;

 private:
  Result<bool> read(RayRow& row) override {
    while (numbers_.size() < kNumbersOfRay) {
      auto more = read_line();
      if (!more) return more;
      if (*more) continue;
      return numbers_.empty() ? Result<bool>(false) : cut_off();
    }
    for (std::size_t k = 0; k < kNumbersOfRay; ++k) {
      row[k] = numbers_.front();
      numbers_.pop_front();
    }
    return true;
  }

  Result<bool> is_there() override {
    while (numbers_.size() < kNumbersOfRay) {
      const auto line = input().ready_line();
      if (!line) return line.error();
      if (!*line) return false;
      if ((*line)->at_end) return true;
      auto more = read_line();
      if (!more) return more;
    }
    return true;
  }

  Result<bool> read_line() {
    std::string_view line;
    auto more = input().next_line(line);
    if (!more || !*more) return more;
    ++line_number_;
    constexpr std::string_view kBlanks = " \t\r\v\f";
    while (true) {
      line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
      if (line.empty()) return true;
      const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
      const auto number = parse_number(word);
      if (!number) return no_number(word);
      numbers_.push_back(*number);
      line.remove_prefix(word.size());
    }
  }

  Error no_number(std::string_view word) {
    constexpr std::size_t kLongestShown = 40;
    return local_error(fmt::format("{}:{}: '{}' is not a number", input().name(), line_number_,
                                   word.substr(0, kLongestShown)));
  }

  std::deque<double> numbers_;
  std::uint64_t line_number_ = 0;
};

template <class Number>
class BinaryRays : public RtraceReader {
 public:
  using RtraceReader::RtraceReader;

 private:
  using Numbers = std::array<Number, kNumbersOfRay>;

  Result<bool> read(RayRow& row) override {
    const auto bytes = input().next_bytes(sizeof(Numbers));
    if (!bytes) return bytes.error();
    if (bytes->empty()) return false;
    if (bytes->size() < sizeof(Numbers)) return cut_off();
    Numbers numbers;
    std::memcpy(numbers.data(), bytes->data(), sizeof(numbers));
    std::copy(numbers.begin(), numbers.end(), row.begin());
    return true;
  }

  Result<bool> is_there() override { return input().ready_bytes(sizeof(Numbers)); }
};

std::optional<RtraceNumbers> numbers_of(char letter) {
  if (letter == 'a') return RtraceNumbers::kText;
  if (letter == 'f') return RtraceNumbers::kFloat;
  if (letter == 'd') return RtraceNumbers::kDouble;
  return {};
}

}  // namespace

Result<RtraceEncoding> parse_rtrace_encoding(std::string_view letters) {
  const auto in = letters.empty() ? std::optional<RtraceNumbers>() : numbers_of(letters.front());
  const auto out = letters.empty() ? std::optional<RtraceNumbers>() : numbers_of(letters.back());
  if (letters.size() <= 2 && in && out) return RtraceEncoding{*in, *out};
  return local_error(
      fmt::format("'{}' is not one or two of a (text), f (float) and d (double)", letters));
}

std::shared_ptr<RowReader> make_rtrace_rays(Input input, const RtraceRayOptions& options) {
  switch (options.numbers) {
    case RtraceNumbers::kFloat:
      return std::make_shared<BinaryRays<float>>(std::move(input), options);
    case RtraceNumbers::kDouble:
      return std::make_shared<BinaryRays<double>>(std::move(input), options);
    case RtraceNumbers::kText:
      break;
  }
  return std::make_shared<TextRays>(std::move(input), options);
}

}  // namespace sightline::client::cli::files
