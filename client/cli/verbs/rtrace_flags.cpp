// Knows for each flag of rtrace how many values follow it.
#include "client/cli/verbs/rtrace_flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "client/cli/flags.h"

namespace sightline::client::cli::verbs {
namespace {

using Words = std::deque<std::string>;

constexpr int kMostExpansions = 1000;  // a file that names itself

// A flag without effect. Its values are integers, other numbers or any words: i, f and s.
struct Unused {
  std::string_view flag;
  std::string_view values;
};
constexpr std::array kUnused = std::to_array<Unused>({
    {"-ab", "i"},   {"-aa", "f"},   {"-ar", "i"},        {"-ad", "i"},  {"-as", "i"},
    {"-aw", "i"},   {"-ai", "s"},   {"-aI", "s"},        {"-ae", "s"},  {"-aE", "s"},
    {"-af", "s"},   {"-am", "f"},   {"-dt", "f"},        {"-dc", "f"},  {"-dj", "f"},
    {"-ds", "f"},   {"-dr", "i"},   {"-dp", "i"},        {"-st", "f"},  {"-ss", "f"},
    {"-lr", "i"},   {"-lw", "f"},   {"-mg", "f"},        {"-ms", "f"},  {"-ti", "s"},
    {"-tI", "s"},   {"-te", "s"},   {"-tE", "s"},        {"-n", "i"},   {"-e", "s"},
    {"-P", "s"},    {"-PP", "s"},   {"-cs", "i"},        {"-cw", "ff"}, {"-pY", ""},
    {"-pS", ""},    {"-pM", ""},    {"-pRGB", ""},       {"-pXYZ", ""}, {"-av", "fff"},
    {"-me", "fff"}, {"-ma", "fff"}, {"-pc", "ffffffff"},
});

// A switch. It turns around without a letter, and is set or not by one.
struct Switch {
  std::string_view flag;
  std::string_view spelled;  // empty: it has no effect
  bool is_on;                // by default
};
constexpr std::array kSwitches = std::to_array<Switch>({
    {"-ld", "--limit", false},
    {"-bv", "--backs", true},
    {"-h", "--header", true},
    {"-w", "--warnings", true},
    {"-dv", "", true},
    {"-co", "", false},
    {"-u", "", false},
    {"-i", "", false},
    {"-I", "", false},
});

constexpr std::string_view kOn = "yYtT+1", kOff = "nNfF-0";

bool is_switch(const std::string& word, const Switch& known) {
  if (!word.starts_with(known.flag)) return false;
  const std::string_view rest = std::string_view(word).substr(known.flag.size());
  return rest.empty() || (rest.size() == 1 && (kOn.find(rest) != std::string_view::npos ||
                                               kOff.find(rest) != std::string_view::npos));
}

void check_value(const Unused& known, char kind, const std::string& value) {
  if (kind == 's') return;
  const auto number = parse_number(value);
  if (number && (kind == 'f' || *number == std::round(*number))) return;
  throw CLI::ValidationError(
      std::string(known.flag),
      fmt::format("'{}' is not {}", value, kind == 'i' ? "an integer" : "a number"));
}

// The words after the verb.
class Speller {
 public:
  explicit Speller(Words words) : words_(std::move(words)) {
    for (const Switch& known : kSwitches) on_.push_back(known.is_on);
  }

  std::vector<std::string> spell() {
    while (!words_.empty()) {
      std::string word = std::move(words_.front());
      words_.pop_front();
      if (!expand(word) && !take(word) && !turn(word)) spelled_.push_back(std::move(word));
    }
    return std::move(spelled_);
  }

 private:
  bool expand(const std::string& word) {
    if (word.size() < 2 || (word[0] != '$' && word[0] != '@')) return false;
    if (++expansions_ > kMostExpansions)
      throw CLI::ValidationError(word, "it stands for words that stand for others without an end");
    std::istringstream text(word[0] == '$' ? variable(word) : file(word));
    const Words more{std::istream_iterator<std::string>(text), {}};
    words_.insert(words_.begin(), more.begin(), more.end());
    return true;
  }

  static std::string variable(const std::string& word) {
    // No thread of the command changes the environment.
    const char* const value = std::getenv(word.c_str() + 1);  // NOLINT(concurrency-mt-unsafe)
    if (value == nullptr) throw CLI::ValidationError(word, "there is no such variable");
    return value;
  }

  static std::string file(const std::string& word) {
    std::ifstream in(word.substr(1));
    std::ostringstream text;
    if (in.peek() != std::ifstream::traits_type::eof()) text << in.rdbuf();
    if (!in) throw CLI::ValidationError(word, "the file cannot be read, or is empty");
    return text.str();
  }

  bool take(const std::string& word) {
    const auto* const known = std::find_if(
        kUnused.begin(), kUnused.end(), [&](const Unused& unused) { return unused.flag == word; });
    if (known == kUnused.end()) return false;
    if (words_.size() < known->values.size()) {
      throw CLI::ValidationError(word, fmt::format("it takes {} value{}", known->values.size(),
                                                   known->values.size() == 1 ? "" : "s"));
    }
    for (const char kind : known->values) {
      check_value(*known, kind, words_.front());
      words_.pop_front();
    }
    note(word);
    return true;
  }

  bool turn(const std::string& word) {
    const auto* const known =
        std::find_if(kSwitches.begin(), kSwitches.end(),
                     [&](const Switch& candidate) { return is_switch(word, candidate); });
    if (known == kSwitches.end()) return false;
    const auto index = static_cast<std::size_t>(known - kSwitches.begin());
    on_[index] = word.size() == known->flag.size()
                     ? !on_[index]
                     : kOn.find(word.back()) != std::string_view::npos;
    if (known->spelled.empty()) {
      note(std::string(known->flag));
    } else {
      spelled_.push_back(fmt::format("{}={}", known->spelled, on_[index]));
    }
    return true;
  }

  void note(const std::string& flag) { spelled_.push_back("--no-effect=" + flag); }

  Words words_;
  std::vector<bool> on_;  // which of kSwitches are on
  int expansions_ = 0;
  std::vector<std::string> spelled_;
};

// The index of the verb: the first word that is neither a flag of the program nor the value of one.
std::size_t index_of_verb(const std::vector<std::string>& words) {
  constexpr std::array<std::string_view, 6> kWithValue{"--endpoint", "--tls-ca",     "--tls-cert",
                                                       "--tls-key",  "--token-file", "--deadline"};
  std::size_t i = 0;
  while (i < words.size() && words[i].starts_with('-'))
    i += std::find(kWithValue.begin(), kWithValue.end(), words[i]) == kWithValue.end() ? 1 : 2;
  return i;
}

}  // namespace

void spell_out_rtrace_flags(std::vector<std::string>& words) {
  const std::size_t verb = index_of_verb(words);
  if (verb >= words.size() || words[verb] != "rtrace") return;
  const auto after = words.begin() + static_cast<std::ptrdiff_t>(verb) + 1;
  std::vector<std::string> spelled = Speller(Words(after, words.end())).spell();
  words.erase(after, words.end());
  words.insert(words.end(), std::make_move_iterator(spelled.begin()),
               std::make_move_iterator(spelled.end()));
}

}  // namespace sightline::client::cli::verbs
