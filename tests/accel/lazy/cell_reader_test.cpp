// Every form of a cell's list is read as the same slices.
#include "accel/lazy/cell_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <vector>

#include "accel/lazy/cancelled.h"
#include "tests/accel/boxes.h"

namespace sightline::accel::lazy {
namespace {

constexpr std::size_t kSize = 3 * kdtree::kReferencesPerSlice + 17;

struct Source {
  std::vector<kdtree::Reference> refs = tests::random_boxes(kSize, 0.01, 3);
  std::shared_ptr<const ReferenceSource> of = make();

  std::shared_ptr<const ReferenceSource> make() const {
    ReferenceSource source = source_of(refs);
    source.again = [this](std::span<const std::uint32_t> ids, kdtree::Reference* out,
                          kdtree::BuildCounters&) {
      for (const std::uint32_t id : ids) *out++ = refs[id];
    };
    return std::make_shared<const ReferenceSource>(source);
  }
};

/// Cells with the same references: without a list, compact, and with a list in uneven pieces.
std::vector<std::unique_ptr<kdtree::DeferredCell>> forms(const Source& source) {
  std::vector<std::unique_ptr<kdtree::DeferredCell>> cells(3);
  for (auto& cell : cells) cell = std::make_unique<kdtree::DeferredCell>();
  cells[0]->has_list = false;
  std::vector<std::uint32_t> ids(kSize);
  std::iota(ids.begin(), ids.end(), 0u);
  cells[1]->list =
      kdtree::CellList(kdtree::SharedArray<std::uint32_t>(std::span<const std::uint32_t>(ids)));
  std::vector<kdtree::ReferenceList> pieces;
  for (std::size_t begin = 0, size = 1000; begin < kSize; begin += size, size = 2 * size + 1) {
    size = std::min(size, kSize - begin);
    pieces.emplace_back(std::span<const kdtree::Reference>(source.refs).subspan(begin, size));
    pieces.emplace_back();
  }
  cells[2]->list = kdtree::CellList(std::move(pieces));
  return cells;
}

std::vector<std::uint32_t> ids_of(std::span<const kdtree::Reference> refs) {
  std::vector<std::uint32_t> ids;
  for (const kdtree::Reference& ref : refs) ids.push_back(ref.id);
  return ids;
}

TEST(CellReader, ReadsAllFormsOfAListAsTheSameSlices) {
  const Source source;
  for (const auto& cell : forms(source)) {
    kdtree::BuildCounters counters;
    const CellReader reader(source.of, *cell, counters);
    EXPECT_EQ(reader.size(), kSize);
    ASSERT_EQ(reader.slices(), 4u);
    EXPECT_FALSE(reader.openable());
    EXPECT_EQ(ids_of(reader.read_all(counters).all()), ids_of(source.refs));
    std::vector<kdtree::Reference> slice(kdtree::kReferencesPerSlice);
    EXPECT_EQ(reader.read(3, slice.data(), counters), 17u);
    EXPECT_EQ(slice[0].id, source.refs[3 * kdtree::kReferencesPerSlice].id);
    const std::vector<std::size_t> indices{0, 5000, kSize - 1};
    EXPECT_EQ(ids_of(reader.pick(indices, counters)),
              (std::vector{source.refs[0].id, source.refs[5000].id, source.refs.back().id}));
  }
}

TEST(CellReader, OutlivesTheCell) {
  const Source source;
  kdtree::BuildCounters counters;
  auto cells = forms(source);
  const CellReader reader(source.of, *cells[2], counters);
  cells.clear();
  EXPECT_EQ(ids_of(reader.read_all(counters).all()), ids_of(source.refs));
}

TEST(CellReader, LeavesWhenItIsCancelled) {
  const Source source;
  const std::atomic<bool> cancelled{true};
  for (const auto& cell : forms(source)) {
    kdtree::BuildCounters counters;
    EXPECT_THROW(CellReader(source.of, *cell, counters).read_all(counters, &cancelled), Cancelled);
  }
}

TEST(CellReader, AShortListIsOneSliceThatIsNotCopied) {
  const Source source;
  kdtree::DeferredCell cell;
  const kdtree::ReferenceList list(std::span<const kdtree::Reference>(source.refs).first(100));
  cell.list = kdtree::CellList(list);
  kdtree::BuildCounters counters;
  const CellReader reader(source.of, cell, counters);
  ASSERT_EQ(reader.slices(), 1u);
  reader.list().each_part(0, [&](std::span<const kdtree::Reference> part) {
    EXPECT_EQ(part.data(), list.all().data());
    EXPECT_EQ(part.size(), 100u);
  });
}

}  // namespace
}  // namespace sightline::accel::lazy
