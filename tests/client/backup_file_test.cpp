// The files of a backup: what a server sends is kept, and what is not whole is refused.
#include "client/backup_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/sha256.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client {
namespace {

namespace fs = std::filesystem;

std::string sum_of(const std::string& bytes) {
  Sha256 sum;
  sum.add(std::as_bytes(std::span(bytes)));
  return sum.hex();
}

std::string digest_of(const std::string& bytes) {
  return "sha256:" + sum_of(bytes) + "/" + std::to_string(bytes.size());
}

/// The bytes of a mesh, longer than a piece.
std::string mesh_of(char letter) { return std::string(std::size_t{700} << 10, letter); }

v1::BackupPart piece(const std::string& digest, const std::string& data, bool more) {
  v1::BackupPart part;
  part.mutable_mesh()->set_digest(digest);
  part.mutable_mesh()->set_data(data);
  part.mutable_mesh()->set_more(more);
  return part;
}

class BackupFiles : public testing::Test {
 protected:
  /// Writes a backup of these meshes, each in two pieces, or only named where it is known.
  Status write(const std::string& name, const std::vector<std::string>& meshes,
               const std::string& since = {}) {
    auto file = BackupFileWriter::create(dir_.path(name),
                                         since.empty() ? fs::path() : fs::path(dir_.path(since)));
    if (!file) return file.error();
    const auto known = file->known();
    for (const std::string& mesh : meshes) {
      const std::string digest = digest_of(mesh);
      const bool is_known = std::ranges::find(known, digest) != known.end();
      if (is_known) {
        if (Status added = file->add(piece(digest, "", false)); !added) return added;
        continue;
      }
      if (Status added = file->add(piece(digest, mesh.substr(0, 3), true)); !added) return added;
      if (Status added = file->add(piece(digest, mesh.substr(3), false)); !added) return added;
    }
    v1::BackupPart end;
    end.mutable_end();
    if (Status added = file->add(end); !added) return added;
    return file->finish();
  }

  /// The meshes of a backup, as a server gets them.
  Result<std::vector<std::string>> read(const std::string& name) {
    auto file = BackupFileReader::open(dir_.path(name));
    if (!file) return file.error();
    std::vector<std::string> meshes;
    std::string bytes;
    for (v1::BackupPart part;;) {
      const auto more = file->next(part);
      if (!more) return more.error();
      if (!*more) return meshes;
      if (!part.has_mesh()) continue;
      bytes += part.mesh().data();
      if (part.mesh().more()) continue;
      EXPECT_EQ(part.mesh().digest(), digest_of(bytes));
      meshes.push_back(std::exchange(bytes, {}));
    }
  }

  fs::path mesh_file(const std::string& name, const std::string& mesh) {
    return fs::path(dir_.path(name)) / "meshes" / sum_of(mesh);
  }

  const std::string a_ = mesh_of('a'), b_ = mesh_of('b'), c_ = "small";
  tests::TempDir dir_;
};

TEST_F(BackupFiles, ComeBackAsTheyWereSent) {
  ASSERT_TRUE(write("one", {a_, c_}));
  const auto meshes = read("one");
  ASSERT_TRUE(meshes) << meshes.error().message;
  EXPECT_EQ(*meshes, (std::vector<std::string>{a_, c_}));
}

TEST_F(BackupFiles, ShareTheMeshesOfAnEarlierBackup) {
  ASSERT_TRUE(write("one", {a_, c_}));
  ASSERT_TRUE(write("two", {a_, b_}, "one"));
  ASSERT_TRUE(write("three", {b_, a_}, "two"));
  EXPECT_EQ(fs::hard_link_count(mesh_file("one", a_)), 3u);
  EXPECT_EQ(fs::hard_link_count(mesh_file("two", b_)), 2u);
  EXPECT_EQ(fs::hard_link_count(mesh_file("one", c_)), 1u);
  fs::remove_all(dir_.path("one"));
  fs::remove_all(dir_.path("two"));
  const auto meshes = read("three");
  ASSERT_TRUE(meshes) << meshes.error().message;
  EXPECT_EQ(*meshes, (std::vector<std::string>{b_, a_}));
}

TEST_F(BackupFiles, AMeshThatIsSentAgainIsLinkedToo) {
  ASSERT_TRUE(write("one", {a_}));
  auto file = BackupFileWriter::create(dir_.path("two"), dir_.path("one"));
  ASSERT_TRUE(file);
  ASSERT_TRUE(file->add(piece(digest_of(a_), a_, false)));
  ASSERT_TRUE(file->finish());
  EXPECT_EQ(fs::hard_link_count(mesh_file("two", a_)), 2u);
}

TEST_F(BackupFiles, AnEarlierBackupThatIsNotWholeIsRefused) {
  ASSERT_TRUE(write("one", {a_, c_}));
  EXPECT_FALSE(write("two", {a_}, "nowhere"));
  EXPECT_FALSE(fs::exists(dir_.path("two"))) << "nothing is begun";
  std::ofstream(mesh_file("one", c_), std::ios::app) << "x";
  const Status refused = write("two", {a_}, "one");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kDataLoss);
  EXPECT_NE(refused.error().message.find(mesh_file("one", c_).string()), std::string::npos);
  EXPECT_FALSE(read("one"));
  fs::remove(mesh_file("one", c_));
  EXPECT_FALSE(read("one"));
}

TEST_F(BackupFiles, WhatTheServerMustNotSendIsRefused) {
  const std::string digest = digest_of(a_), zeros(64, '0');
  for (const v1::BackupPart& wrong :
       {piece("sha256:../../../../../../../../../../../../../../../../../../../../etc/pa/7", "x",
              false),
        piece("sha256:" + zeros, "x", false), piece("sha256:" + zeros + "/", "x", false),
        piece("sha256:" + zeros + "/1x", "x", false), piece("sha256:" + zeros + "/1", "x", false),
        piece("", "x", false), piece(digest, "", false), piece(digest, "other", false),
        piece(digest, a_ + "x", false)}) {
    fs::remove_all(dir_.path("wrong"));
    auto file = BackupFileWriter::create(dir_.path("wrong"), {});
    ASSERT_TRUE(file);
    const Status added = file->add(wrong);
    ASSERT_FALSE(added) << wrong.mesh().digest();
    EXPECT_EQ(added.error().code, Code::kDataLoss) << added.error().message;
  }
  auto file = BackupFileWriter::create(dir_.path("cut"), {});
  ASSERT_TRUE(file);
  ASSERT_TRUE(file->add(piece(digest, "a", true)));
  EXPECT_FALSE(file->add(piece(digest_of(b_), "b", true))) << "another mesh between";
  EXPECT_FALSE(file->finish()) << "the mesh has no end";
}

TEST_F(BackupFiles, AFileOfSumsNamesNothingElse) {
  ASSERT_TRUE(write("one", {c_}));
  const std::string sums = dir_.path("one") + "/SHA256SUMS";
  std::string text;
  std::getline(std::ifstream(sums), text, '\0');
  for (const std::string& line : {sum_of(c_) + "  ../one/meshes/" + sum_of(c_), sum_of(c_) + "  x",
                                  std::string("x"), std::string("../../x  meshes/../../x")}) {
    std::ofstream(sums) << text << line << "\n";
    EXPECT_FALSE(read("one")) << line;
  }
  std::ofstream(sums) << "";
  EXPECT_FALSE(read("one"));
}

TEST_F(BackupFiles, BackupsWithTheMeshesInTheirPartsAreRead) {
  fs::create_directory(dir_.path("old"));
  std::string bytes;
  for (const v1::BackupPart& part :
       {piece(digest_of(a_), a_.substr(0, 9), true), piece(digest_of(a_), a_.substr(9), false)}) {
    const std::string text = part.SerializeAsString();
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>(text.size() >> (8 * i));
    bytes += text;
  }
  std::ofstream(dir_.path("old") + "/scenes.parts") << bytes;
  std::ofstream(dir_.path("old") + "/SHA256SUMS") << sum_of(bytes) << "  scenes.parts\n";
  const auto meshes = read("old");
  ASSERT_TRUE(meshes) << meshes.error().message;
  EXPECT_EQ(*meshes, std::vector<std::string>{a_});
  EXPECT_TRUE(write("new", {a_}, "old"));
}

}  // namespace
}  // namespace sightline::client
