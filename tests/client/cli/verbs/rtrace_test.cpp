// rtrace as a script of Radiance's program would call it.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
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
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"-ov"},
                                                {"-fc"},
                                                {"-ff", "-os"},
                                                {"-ab"},
                                                {"-av", "1", "2"},
                                                {"-lr", "x"},
                                                {"-n", "1.5"},
                                                {"-ap", "map"},
                                                {"-M", "mods"},
                                                {"@none.opt"},
                                                {"$NOT_SET_ANYWHERE"},
                                                {"--json"}}) {
    std::vector<std::string> words{"rtrace", "square"};
    words.insert(words.end(), wrong.begin(), wrong.end());
    const ProgramOutcome outcome = run_program(words);
    EXPECT_EQ(outcome.exit, 2) << wrong[0] << outcome.err;
    EXPECT_NE(outcome.err, "");
  }
  EXPECT_NE(run_program({"rtrace", "--help"}).out.find("Examples:\n"), std::string::npos);
}

TEST_F(Rtrace, FlagsOfScriptsAreTaken) {
  const std::string expected = "3.000000e+00\t\n";
  for (const std::vector<std::string>& flags : std::vector<std::vector<std::string>>{
           {"-ab", "2"},
           {"-aa", ".15", "-ar", "300", "-ad", "1024", "-as", "512"},
           {"-av", "0", "0.5", "1"},
           {"-lr", "-10", "-lw", "1e-4"},
           {"-dj", "0", "-ds", ".2"},
           {"-dt", ".05", "-dc", ".5", "-dr", "3", "-dp", "512"},
           {"-st", "0.1", "-ss", "1"},
           {"-me", "0", "0", "0", "-ma", "0", "0", "0", "-mg", "0", "-ms", "0"},
           {"-u+"},
           {"-dv-"},
           {"-n", "8"},
           {"-w"},
           {"-w+"},
           {"-w-"},
           {"-I"},
           {"-I+"},
           {"-i"},
           {"-i0"},
           {"-bv"},
           {"-bv+"},
           {"-e", "errors.txt"},
           {"-P", "file"},
           {"-PP", "file"},
           {"-af", "amb.amb"},
           {"-ti", "mod"},
           {"-te", "mod"},
           {"-pRGB"},
           {"-pY"},
           {"-pc", ".64", ".33", ".29", ".6", ".15", ".06", ".333", ".333"},
           {"-aw", "0"}}) {
    std::vector<std::string> words = flags;
    words.insert(words.end(), {"-h", "-oL"});
    EXPECT_EQ(traced(words, kDown), expected) << flags[0];
  }
}

TEST_F(Rtrace, ASwitchTurnsAround) {
  EXPECT_EQ(traced({"-h", "-h", "-h0", "-oL"}, kDown), "3.000000e+00\t\n");
  EXPECT_EQ(traced({"-hn", "-ld", "-ld", "-oL"}, kDown), "3.000000e+00\t\n");
  EXPECT_EQ(traced({"-h-", "-ldy", "-oL"}, kDown), "1.000000e+10\t\n");
  EXPECT_NE(traced({"-hT", "-oL"}, kDown).find("#?RADIANCE"), std::string::npos);
}

TEST_F(Rtrace, BacksOfFacesAreInvisibleOnRequest) {
  const std::string up = "0.75 0.25 -3 0 0 1\n";
  EXPECT_EQ(traced({"-h", "-oL"}, up), "3.000000e+00\t\n");
  for (const char* flag : {"-bv", "-bv-", "-bv0"})
    EXPECT_EQ(traced({"-h", flag, "-oL"}, kDown + up), "3.000000e+00\t\n1.000000e+10\t\n");
}

TEST_F(Rtrace, WordsOfFilesAndVariables) {
  const std::string options = dir_.write("rt.opt", "-h -ab 2\n-lr 0 -oL\n");
  EXPECT_EQ(traced({"@" + options}, kDown), "3.000000e+00\t\n");
  ::setenv("SIGHTLINE_TEST_OPTIONS", ("-ad 64 @" + options).c_str(),
           1);  // NOLINT(concurrency-mt-unsafe)
  EXPECT_EQ(traced({"$SIGHTLINE_TEST_OPTIONS"}, kDown), "3.000000e+00\t\n");
  const std::string endless = dir_.write("endless.opt", "-ab 2 @" + dir_.path("endless.opt"));
  EXPECT_EQ(run_program({"rtrace", "@" + endless, "square"}).exit, 2);
}

TEST_F(Rtrace, OneNoteNamesTheFlagsWithoutEffect) {
  const auto noted = [](std::vector<std::string> flags) {
    std::vector<std::string> words{"rtrace", "-x", "0", "-h"};
    words.insert(words.end(), flags.begin(), flags.end());
    words.emplace_back("none");
    return run_program(words).err;
  };
  const std::string note = noted({"-ab", "2", "-n", "4", "-ab", "3", "-I+"});
  EXPECT_NE(note.find("without effect: -ab -n -I: "), std::string::npos) << note;
  for (const char* silent : {"-w", "-w-", "-q"})
    EXPECT_EQ(noted({"-ab", "2", silent}).find("without effect"), std::string::npos) << silent;
  EXPECT_EQ(noted({"-ld", "-bv"}).find("without effect"), std::string::npos);
}

TEST_F(Rtrace, OtherVerbsHaveTheirOwnFlags) {
  EXPECT_EQ(run_program({"scene", "show", "rtrace", "-n", "4"}).exit, 2);
  EXPECT_EQ(run_program({"--deadline", "5", "rtrace", "-n", "4", "none"}).exit, 3);
}

}  // namespace
}  // namespace sightline::tests
