// Single bits of a data directory are flipped: each flip is harmless, or the call that it concerns
// is refused, or the doctor finds it. SIGHTLINE_FLIPS: how many; SIGHTLINE_SEED: which.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <random>

#include "server/store/doctor.h"
#include "tests/server/store/directory.h"
#include "tests/server/store/store_steps.h"
#include "tests/server/store/stored_state.h"

namespace sightline::server::store {
namespace {

namespace fs = std::filesystem;
using tests::Directory;
using tests::state_of;

std::uint64_t setting(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

constexpr auto kAll = fs::copy_options::recursive | fs::copy_options::overwrite_existing;

struct Flip {
  fs::path file;
  std::uint64_t byte = 0;
  unsigned bit = 0;
};

/// Of all bytes that are not zero; pages that are free say nothing.
class Flips {
 public:
  Flips(const fs::path& directory, std::uint64_t seed) : random_(seed) {
    for (const auto& entry : fs::recursive_directory_iterator(directory)) {
      if (!entry.is_regular_file() || entry.file_size() == 0) continue;
      std::ifstream file(entry.path(), std::ios::binary);
      const std::string bytes{std::istreambuf_iterator<char>(file), {}};
      for (std::uint64_t i = 0; i < bytes.size(); ++i)
        if (bytes[i] != 0) flips_.push_back({fs::relative(entry.path(), directory), i});
    }
  }

  Flip next() {
    Flip flip = flips_[random_() % flips_.size()];
    flip.bit = static_cast<unsigned>(random_() % 8);
    return flip;
  }

 private:
  std::mt19937_64 random_;
  std::vector<Flip> flips_;
};

void apply(const fs::path& directory, const Flip& flip) {
  std::fstream file(directory / flip.file, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(flip.byte));
  const int byte = file.get() ^ (1 << flip.bit);
  file.seekp(static_cast<std::streamoff>(flip.byte));
  file.put(static_cast<char>(byte));
}

enum class Outcome : std::uint8_t { kSame, kRefused, kReported, kSilent };

bool has_findings(const fs::path& directory) {
  const auto found = examine(local_files(), directory, {});
  return !found || !found->findings.empty();
}

/// Of a flipped directory, whose whole state is `want`. The doctor is asked before the store is
/// opened, which renews what has lost its mark, and says so in the log alone.
Outcome outcome_of(const fs::path& directory,
                   const std::map<std::string, Result<std::string>>& want, std::string& wrong) {
  const bool is_found = has_findings(directory);
  bool refused = false;
  {
    const auto store = SqliteStore::open(directory, tests::small_disk());
    if (!store) return Outcome::kRefused;
    const auto got = state_of(**store);
    for (const auto& [what, answer] : got) {
      if (!answer) {
        refused = true;
      } else if (*answer != *want.at(what)) {
        wrong += fmt::format("{}: {} in place of {}\n", what, *answer, *want.at(what));
      }
    }
  }
  if (wrong.empty()) return refused ? Outcome::kRefused : Outcome::kSame;
  return is_found || has_findings(directory) ? Outcome::kReported : Outcome::kSilent;
}

class BitFlips : public testing::Test {
 protected:
  /// As after a clean end, or with the write-ahead log of a crash.
  void flip_all(const fs::path& directory) {
    const Directory copy;
    fs::copy(directory, copy.path(), kAll);
    const auto want = state_of(*tests::open_store(copy.path()));
    for (const auto& [what, answer] : want) ASSERT_TRUE(answer.ok()) << what;
    const std::uint64_t seed = setting("SIGHTLINE_SEED", 1);
    Flips flips(directory, seed);
    std::map<Outcome, int> outcomes;
    const std::uint64_t count = setting("SIGHTLINE_FLIPS", 100);
    for (std::uint64_t i = 0; i < count; ++i) {
      const Directory flipped;
      fs::copy(directory, flipped.path(), kAll);
      const Flip flip = flips.next();
      apply(flipped.path(), flip);
      std::string wrong;
      const Outcome outcome = outcome_of(flipped.path(), want, wrong);
      ++outcomes[outcome];
      EXPECT_NE(outcome, Outcome::kSilent)
          << flip.file << " byte " << flip.byte << " bit " << flip.bit << "\n"
          << wrong;
    }
    fmt::print("seed {}: {} harmless, {} refused, {} reported, {} silent\n", seed,
               outcomes[Outcome::kSame], outcomes[Outcome::kRefused], outcomes[Outcome::kReported],
               outcomes[Outcome::kSilent]);
  }
};

TEST_F(BitFlips, OfADirectoryThatWasClosedAreNeverSilent) {
  const Directory directory;
  tests::fill_store(*tests::open_store(directory.path()));
  flip_all(directory.path());
}

TEST_F(BitFlips, OfADirectoryAfterACrashAreNeverSilent) {
  const Directory directory;
  const Directory crashed;
  const auto store = tests::open_store(directory.path());
  tests::fill_store(*store);
  fs::copy(directory.path(), crashed.path(), kAll);
  flip_all(crashed.path());
}

}  // namespace
}  // namespace sightline::server::store
