// Archives that are whole, and archives that are broken at every byte.
#include "client/cli/files/zip.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace sightline::client::cli::files {
namespace {

std::span<const std::byte> archive_bytes(const std::string& text) {
  return std::as_bytes(std::span(text));
}

std::string entry_text(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// An archive of another program: a.npy, packed with deflate, is 200 times "ray "; b.npy has its
// sizes in the fields of 64 bits.
constexpr const char kDeflated[] =
    "\x50\x4b\x03\x04\x14\x00\x00\x00\x08\x00\x00\x00\x21\x00\xf4\xeb"
    "\xe4\x7d\x0d\x00\x00\x00\x20\x03\x00\x00\x05\x00\x00\x00\x61\x2e"
    "\x6e\x70\x79\x2b\x4a\xac\x54\x28\x1a\xc5\xa3\x78\x14\x63\xc5\x00"
    "\x50\x4b\x03\x04\x2d\x00\x00\x00\x00\x00\x00\x00\x21\x00\xd2\x11"
    "\x5f\xcd\xff\xff\xff\xff\xff\xff\xff\xff\x05\x00\x14\x00\x62\x2e"
    "\x6e\x70\x79\x01\x00\x10\x00\x0a\x00\x00\x00\x00\x00\x00\x00\x0a"
    "\x00\x00\x00\x00\x00\x00\x00\x73\x69\x78\x74\x79\x2d\x66\x6f\x75"
    "\x72\x50\x4b\x01\x02\x14\x03\x14\x00\x00\x00\x08\x00\x00\x00\x21"
    "\x00\xf4\xeb\xe4\x7d\x0d\x00\x00\x00\x20\x03\x00\x00\x05\x00\x00"
    "\x00\x00\x00\x00\x00\x00\x00\x00\x00\x80\x01\x00\x00\x00\x00\x61"
    "\x2e\x6e\x70\x79\x50\x4b\x01\x02\x2d\x03\x2d\x00\x00\x00\x00\x00"
    "\x00\x00\x21\x00\xd2\x11\x5f\xcd\x0a\x00\x00\x00\x0a\x00\x00\x00"
    "\x05\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x00\x80\x01\x30\x00"
    "\x00\x00\x62\x2e\x6e\x70\x79\x50\x4b\x05\x06\x00\x00\x00\x00\x02"
    "\x00\x02\x00\x66\x00\x00\x00\x71\x00\x00\x00\x00\x00";

TEST(Zip, UnpacksDeflateAndFieldsOf64Bits) {
  const auto files = unzip(std::as_bytes(std::span(kDeflated, sizeof(kDeflated) - 1)));
  ASSERT_TRUE(files) << files.error().message;
  ASSERT_EQ(files->at("a.npy").size(), 800U);
  EXPECT_EQ(entry_text(files->at("a.npy")).substr(792), "ray ray ");
  EXPECT_EQ(entry_text(files->at("b.npy")), "sixty-four");
}

TEST(Zip, WhatWasPackedIsUnpacked) {
  const std::vector<ZipEntry> entries{
      {"t.npy", "one"}, {"node.npy", std::string(100'000, 'x')}, {"e", ""}};
  const auto archive = zip(entries);
  ASSERT_TRUE(archive);
  const auto files = unzip(archive_bytes(*archive));
  ASSERT_TRUE(files) << files.error().message;
  ASSERT_EQ(files->size(), entries.size());
  for (const ZipEntry& entry : entries) EXPECT_EQ(entry_text(files->at(entry.name)), entry.bytes);
}

TEST(Zip, AnArchiveThatIsCutOffIsBroken) {
  const auto archive = zip(std::vector<ZipEntry>{{"t.npy", "one"}, {"u.npy", "three"}});
  ASSERT_TRUE(archive);
  for (std::size_t size = 0; size < archive->size(); ++size) {
    const auto files = unzip(archive_bytes(archive->substr(0, size)));
    ASSERT_FALSE(files) << size;
    EXPECT_EQ(files.error().message, ".npz archive is cut off or broken");
  }
}

TEST(Zip, AWrongByteIsNeverReadBeyondTheArchive) {
  const auto archive = zip(std::vector<ZipEntry>{{"t.npy", "one"}, {"u.npy", "three"}});
  ASSERT_TRUE(archive);
  for (std::size_t i = 0; i < archive->size(); ++i) {
    for (const char byte : {'\x00', '\x7f', '\xff'}) {
      std::string wrong = *archive;
      wrong[i] = byte;
      const std::string exact(wrong.data(), wrong.size());
      static_cast<void>(unzip(archive_bytes(exact)));
    }
  }
}

}  // namespace
}  // namespace sightline::client::cli::files
