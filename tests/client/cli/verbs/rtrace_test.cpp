// rtrace as a script of Radiance's program would call it.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "tests/client/support/coprocess.h"
#include "tests/client/support/run_program.h"
#include "tests/client/support/square.h"

namespace sightline::tests {
namespace {

class Rtrace : public LiveProgram {
 protected:
  Rtrace() {
    EXPECT_EQ(run_program({"scene", "import", "square", dir_.write("s.obj", kSquareObj)}).exit, 0);
  }

  static std::string traced(std::vector<std::string> words, const std::string& rays) {
    words.insert(words.begin(), "rtrace");
    words.insert(words.end(), {"square", "--quiet"});
    Coprocess program(words);
    program.write(rays);
    program.close_input();
    std::string out = program.read_rest();
    EXPECT_EQ(program.wait(), 0);
    return out;
  }
};

constexpr const char* kDown = "0.75 0.25 3 0 0 -2\n";

TEST_F(Rtrace, RecordsAreText) {
  EXPECT_EQ(traced({"-h", "-opL"}, kDown),
            "7.500000e-01\t2.500000e-01\t0.000000e+00\t3.000000e+00\t\n");
  EXPECT_EQ(traced({"-h-", "-o", "sL"}, kDown), "square\t3.000000e+00\t\n");
  EXPECT_EQ(traced({"-h-", "-ld", "-oL"}, kDown), "1.000000e+10\t\n")
      << "it ends before the square";
  EXPECT_EQ(traced({"-h-", "-ld-", "-oL"}, kDown), "3.000000e+00\t\n");
}

TEST_F(Rtrace, TheHeaderNamesTheCommand) {
  const std::string text = traced({"-h+", "-oL", "-x", "1", "-y", "1"}, std::string(kDown) + kDown);
  EXPECT_TRUE(
      text.starts_with("#?RADIANCE\nsightline rtrace -fa -oL projects/default/scenes/square\n"))
      << text;
  EXPECT_TRUE(text.ends_with("FORMAT=ascii\n\n-Y 1 +X 1\n3.000000e+00\t\n")) << text;
}

TEST_F(Rtrace, BinaryOfBothSizesAnswersAtOnce) {
  Coprocess program({"rtrace", "-h", "-fdf", "-oLN", "square", "--quiet"});
  for (int i = 1; i <= 10; ++i) {
    const std::array<double, 6> ray{0.75, 0.25, static_cast<double>(i), 0, 0, -1};
    program.write({reinterpret_cast<const char*>(ray.data()), sizeof(ray)});
    std::array<float, 4> record{};
    const std::string bytes = program.read_bytes(sizeof(record));
    ASSERT_EQ(bytes.size(), sizeof(record));
    std::memcpy(record.data(), bytes.data(), sizeof(record));
    EXPECT_EQ(record, (std::array<float, 4>{static_cast<float>(i), 0, 0, 1}));
  }
  program.close_input();
  EXPECT_EQ(program.wait(), 0);
}

TEST_F(Rtrace, WhatItCannotDoIsAUsageError) {
  for (const std::vector<std::string>& wrong :
       {std::vector<std::string>{"-ov"}, {"-fc"}, {"-ff", "-os"}, {"-ab", "2"}, {"--json"}}) {
    std::vector<std::string> words{"rtrace", "square"};
    words.insert(words.end(), wrong.begin(), wrong.end());
    const ProgramOutcome outcome = run_program(words);
    EXPECT_EQ(outcome.exit, 2) << wrong[0] << outcome.err;
    EXPECT_NE(outcome.err, "");
  }
  EXPECT_NE(run_program({"rtrace", "--help"}).out.find("Examples:\n"), std::string::npos);
}

}  // namespace
}  // namespace sightline::tests
