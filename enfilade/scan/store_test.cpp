#include "enfilade/scan/store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <atomic>
#include <cstring>
#include <fstream>
#include <functional>
#include <thread>

#include "enfilade/core/file.h"
#include "enfilade/scan/detail/store_format.h"
#include "tests/support/colour_texel.h"
#include "tests/support/panoramas.h"
#include "tests/support/resident.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::scan {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using tests::resident_bytes_of;
using tests::TemporaryFolder;

std::shared_ptr<const Store> packed(const PanoramaSource& source, const fs::path& folder,
                                    ColourCoding colour = ColourCoding::kRaw) {
  PackOptions options;
  options.colour = colour;
  return Store::open(pack(source, folder, options).file);
}

void expect_equal(const Panorama& a, const Panorama& b) {
  EXPECT_EQ(a.colour, b.colour);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.classes, b.classes);
  EXPECT_EQ(a.instances, b.instances);
}

TEST(Store, ReleasedPicturesLeaveTheMemoryAndCanBeReadAgain) {
  const TemporaryFolder folder("store_release");
  constexpr std::size_t kCount = 4;
  const auto source = testing::memory_panoramas("house", kCount, 256);
  const auto store = packed(*source, folder.path());  // 4.7 MB of colour, uncompressed
  const fs::path file = store_file(folder.path(), "house");
  for (std::size_t i = 0; i < kCount; ++i) read_panorama(*store, ViewpointIndex(i));
  EXPECT_GT(resident_bytes_of(file), store->bytes() / 2);
  for (std::size_t i = 0; i < kCount; ++i) store->release(ViewpointIndex(i));
  EXPECT_LT(resident_bytes_of(file), store->bytes() / 20);  // the catalogue
  for (std::size_t i = 0; i < kCount; ++i) {
    expect_equal(read_panorama(*store, ViewpointIndex(i)),
                 read_panorama(*source, ViewpointIndex(i)));
  }
}

// Packing refuses them; another program may have written the file.
TEST(Store, RefusesIdsThatAreNone) {
  const TemporaryFolder folder("store_ids");
  const auto opened = [&](const std::string& scan, const std::string& viewpoint) -> std::string {
    Connectivity graph{scan, "", {}};
    graph.entries.resize(1);
    graph.entries[0].id = viewpoint;
    graph.entries[0].pose = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    detail::StoreWriter(folder.path() / "s.enfilade", 0, {}).finish(graph);
    try {
      Store::open(folder.path() / "s.enfilade");
    } catch (const InvalidInput& refused) {
      return refused.what();
    }
    return "accepted";
  };
  EXPECT_EQ(opened("one", "v0"), "accepted");
  EXPECT_THAT(opened("../one", "v0"), HasSubstr("catalogue: \"../one\" is not an id"));
  EXPECT_THAT(opened("one", "../../x"), HasSubstr("viewpoint 0: \"../../x\" is not an id"));
  EXPECT_THAT(opened("one", std::string(100'000, 'a')), HasSubstr("(100000 bytes) is not an id"));
}

// A thread that reads what another one releases goes on.
TEST(Store, ReleasingDisturbsNoReader) {
  const TemporaryFolder folder("store_release");
  const auto source = testing::memory_panoramas("house", 1, 64);
  const auto store = packed(*source, folder.path());
  const Panorama right = read_panorama(*source, ViewpointIndex(0));
  std::atomic<bool> done = false;
  std::thread releaser([&] {
    while (!done) {
      store->release(ViewpointIndex(0));
      std::this_thread::yield();
    }
  });
  for (int k = 0; k < 50; ++k) expect_equal(read_panorama(*store, ViewpointIndex(0)), right);
  done = true;
  releaser.join();
}

TEST(Store, GivesBackWhatWasPacked) {
  const TemporaryFolder folder("store_round_trip");
  const auto source = testing::memory_panoramas("house", 3, 16);
  const auto store = packed(*source, folder.path());
  EXPECT_EQ(store->scan(), "house");
  EXPECT_EQ(store->origin(), (folder.path() / "house.enfilade").string());
  EXPECT_EQ(to_json(store->connectivity()), to_json(source->connectivity()));
  ASSERT_EQ(store->size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const ViewpointIndex v(i);
    EXPECT_EQ(store->poses()[i].viewpoint, source->poses()[i].viewpoint);
    EXPECT_EQ(store->poses()[i].position, source->poses()[i].position);
    EXPECT_EQ(store->poses()[i].world_from_panorama, source->poses()[i].world_from_panorama);
    EXPECT_EQ(store->face_sizes(v), source->face_sizes(v));
    expect_equal(read_panorama(*store, v), read_panorama(*source, v));
    testing::BorderedMap here(16), there(16);
    store->read_colour(v, kAllFaces, here.faces());
    source->read_colour(v, kAllFaces, there.faces());
    for (std::size_t k = 0; k < kCubeFaces; ++k) EXPECT_EQ(here.cells(k), there.cells(k));
  }
  EXPECT_TRUE(store->verify().empty());
}

TEST(Store, ReadsRowsOfJpegFaces) {
  constexpr std::uint32_t kSize = 40;
  const TemporaryFolder folder("store_rows"), other("store_rows_raw");
  const auto source = testing::memory_panoramas("house", 1, kSize);
  const auto store = packed(*source, folder.path(), ColourCoding::kJpeg);
  const ViewpointIndex v(0);
  testing::BorderedMap whole(kSize);
  store->read_colour(v, kAllFaces, whole.faces());
  for (const std::uint32_t step : {1U, 7U, 16U, 40U}) {
    testing::BorderedMap parts(kSize);
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      ASSERT_TRUE(store->reads_rows(v, cube_face(k)));
      for (std::uint32_t begin = 0; begin < kSize; begin += step) {
        store->read_colour_rows(v, cube_face(k), {begin, std::min(begin + step, kSize)},
                                parts.faces()[k]);
      }
      EXPECT_EQ(parts.cells(k), whole.cells(k)) << "step " << step;
    }
  }
  EXPECT_FALSE(packed(*source, other.path())->reads_rows(v, CubeFace::kUp));  // raw
  EXPECT_FALSE(source->reads_rows(v, CubeFace::kUp));
}

TEST(Store, HasSeamlessJpegFaces) {
  const TemporaryFolder folder("store_jpeg");
  const auto source = testing::memory_panoramas("house", 1, 32);
  const auto store = packed(*source, folder.path(), ColourCoding::kJpeg);
  const Panorama truth = read_panorama(*source, ViewpointIndex(0));
  const Panorama decoded = read_panorama(*store, ViewpointIndex(0));
  double difference = 0;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    for (std::size_t i = 0; i < truth.colour[k].pixels.size(); ++i) {
      difference += std::abs(truth.colour[k].pixels[i] - decoded.colour[k].pixels[i]);
    }
  }
  // Quality 95 of a smooth picture: rounding of its coefficients.
  EXPECT_LT(difference / (6 * 32 * 32 * 3), 1.5);
  // To the bit: the frame of each face is what the store itself has on the other side of the edge.
  const MemoryPanoramas again(source->connectivity(), {decoded});
  testing::BorderedMap here(32), there(32);
  store->read_colour(ViewpointIndex(0), kAllFaces, here.faces());
  again.read_colour(ViewpointIndex(0), kAllFaces, there.faces());
  for (std::size_t k = 0; k < kCubeFaces; ++k) EXPECT_EQ(here.cells(k), there.cells(k));
}

// Sizes at which cells, records and pages do and do not end together.
TEST(Store, DecodedStoresAreDrawnFromAsTheyStand) {
  for (const std::uint32_t size : {1U, 18U, 33U}) {
    const TemporaryFolder folder("store_decoded");
    const auto source = testing::memory_panoramas("house", 3, size);
    PackOptions options;
    options.colour = ColourCoding::kRaw;
    options.decoded = true;
    pack(*source, folder.path(), options);
    const auto store = Store::open(folder.path() / "house.enfilade");
    EXPECT_TRUE(store->verify().empty());
    for (std::size_t i = 0; i < 3; ++i) {
      const ViewpointIndex v(i);
      expect_equal(read_panorama(*store, v), read_panorama(*source, v));
      testing::BorderedMap expected(size);
      source->read_colour(v, kAllFaces, expected.faces());
      for (std::size_t l = 0; l < kLayers; ++l) {
        EXPECT_TRUE(store->has_cells(static_cast<Layer>(l), v));
        for (std::size_t k = 0; k < kCubeFaces; ++k) {
          const std::uint8_t* cells = store->cells(static_cast<Layer>(l), v, cube_face(k));
          EXPECT_EQ(reinterpret_cast<std::uintptr_t>(cells) % image::kCellBytes, 0U);
          if (l > 0) continue;
          for (std::ptrdiff_t y = -1; y <= std::ptrdiff_t{size}; ++y) {
            for (std::ptrdiff_t x = -1; x <= std::ptrdiff_t{size}; ++x) {
              ASSERT_EQ(image::colour_texel(cells, size, x, y),
                        image::colour_texel(expected.cells(k).data(), size, x, y));
            }
          }
        }
      }
    }
  }
}

TEST(Store, DecodedStoresOfJpegsHaveTheTexelsThatReadersDecode) {
  const TemporaryFolder folder("store_decoded_jpeg");
  const auto source = testing::memory_panoramas("house", 1, 32);
  const auto jpeg = packed(*source, folder.path(), ColourCoding::kJpeg);
  PackOptions options;
  options.decoded = true;
  pack(*jpeg, folder.path() / "decoded", options);
  const auto store = Store::open(folder.path() / "decoded" / "house.enfilade");
  expect_equal(read_panorama(*store, ViewpointIndex(0)), read_panorama(*jpeg, ViewpointIndex(0)));
  EXPECT_FALSE(store->colour_jpegs(ViewpointIndex(0)).has_value());
}

TEST(Store, ADamagedFaceInCellsIsRefused) {
  const TemporaryFolder folder("store_decoded_damaged");
  const auto source = testing::memory_panoramas("house", 1, 16);
  PackOptions options;
  options.decoded = true;
  const auto file = pack(*source, folder.path(), options).file;
  {
    std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
    out.seekp(2000);  // in the first face's cells
    out.put(static_cast<char>(0x5A));
  }
  const auto store = Store::open(file);
  EXPECT_THAT([&] { store->cells(Layer::kColour, ViewpointIndex(0), CubeFace::kUp); },
              ThrowsMessage<InvalidInput>(HasSubstr("face 0")));
  EXPECT_NE(store->cells(Layer::kColour, ViewpointIndex(0), CubeFace::kBack), nullptr);
}

TEST(Store, ReadsOneFaceAlone) {
  const TemporaryFolder folder("store_one_face");
  const auto source = testing::memory_panoramas("house", 2, 16);
  const auto store = packed(*source, folder.path(), ColourCoding::kJpeg);
  testing::BorderedMap all(16), one(16), untouched(16);
  store->read_colour(ViewpointIndex(1), kAllFaces, all.faces());
  store->read_colour(ViewpointIndex(1), 1 << 4, one.faces());
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    EXPECT_EQ(one.cells(k), (k == 4 ? all : untouched).cells(k));
  }
  std::vector<std::uint32_t> instances(256);
  std::array<std::uint32_t*, kCubeFaces> buffers{};
  buffers[2] = instances.data();
  store->read_instances(ViewpointIndex(1), 1 << 2, buffers);
  EXPECT_EQ(instances, testing::panorama(16, 2).instances[2].pixels);
}

TEST(Store, KnowsWhichLayersAreMissing) {
  const TemporaryFolder folder("store_layers");
  Panorama colour = testing::panorama(8, 1), depth = testing::panorama(8, 2);
  colour.depth = colour.classes = {};
  colour.instances = {};
  depth.colour = {};
  const MemoryPanoramas source(testing::row_of_viewpoints("house", 3), {colour, {}, depth});
  const auto store = packed(source, folder.path());
  EXPECT_EQ(store->face_sizes(ViewpointIndex(0)), (FaceSizes{8, 0, 0, 0}));
  EXPECT_EQ(store->face_sizes(ViewpointIndex(1)), FaceSizes{});
  EXPECT_EQ(store->face_sizes(ViewpointIndex(2)), (FaceSizes{0, 8, 8, 8}));
  expect_equal(read_panorama(*store, ViewpointIndex(0)), colour);
  expect_equal(read_panorama(*store, ViewpointIndex(2)), depth);
  EXPECT_THAT([&] { store->read_16(Layer::kDepth, ViewpointIndex(0), kAllFaces, {}); },
              ThrowsMessage<LookupError>(
                  AllOf(HasSubstr("no depth"), HasSubstr("\"v0\""), HasSubstr("house.enfilade"))));
  EXPECT_THROW(store->read_colour(ViewpointIndex(2), kAllFaces, {}), LookupError);
  EXPECT_THROW(store->colour_jpegs(ViewpointIndex(2)), LookupError);
}

TEST(Store, IsReadByManyThreads) {
  const TemporaryFolder folder("store_threads");
  const auto source = testing::memory_panoramas("house", 4, 32);
  const auto store = packed(*source, folder.path());
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (std::size_t i = 0; i < 4; ++i) {
        expect_equal(read_panorama(*store, ViewpointIndex(i)), testing::panorama(32, i + 1));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(Store, HandsOnItsJpegs) {
  const TemporaryFolder folder("store_jpegs"), other("store_jpegs_other");
  const auto source = testing::memory_panoramas("house", 2, 16);
  const auto first = packed(*source, folder.path(), ColourCoding::kJpeg);
  const auto second = packed(*first, other.path(), ColourCoding::kKeep);
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_TRUE(first->colour_jpegs(ViewpointIndex(i)).has_value());
    EXPECT_EQ(first->colour_jpegs(ViewpointIndex(i)), second->colour_jpegs(ViewpointIndex(i)));
    expect_equal(read_panorama(*second, ViewpointIndex(i)),
                 read_panorama(*first, ViewpointIndex(i)));
  }
  EXPECT_NE(first->state(), packed(*source, other.path())->state());
  EXPECT_EQ(packed(*source, other.path())->colour_jpegs(ViewpointIndex(0)), std::nullopt);
}

// --- files that are not as they were ---------------------------------------------------------

// A small store that may be changed, byte by byte.
class Damage : public ::testing::Test {
 protected:
  Damage() {
    PackOptions options;
    options.colour = ColourCoding::kJpeg;
    Panorama second = testing::panorama(3, 8);
    second.classes = {};
    file_ = pack(MemoryPanoramas(testing::row_of_viewpoints("tiny", 3),
                                 {testing::panorama(4, 7), second, {}}),
                 folder_.path(), options)
                .file;
    bytes_ = read_file(file_);
  }

  void write(const std::string& bytes) const {
    std::ofstream(file_, std::ios::binary).write(bytes.data(), std::ssize(bytes));
  }
  void write_byte(std::size_t at, char byte) const {
    std::fstream(file_, std::ios::binary | std::ios::in | std::ios::out)
        .seekp(static_cast<std::streamoff>(at))
        .put(byte);
  }
  detail::Header header() const {
    detail::Header header;
    std::memcpy(&header, bytes_.data(), sizeof(header));
    return header;
  }
  // The store with a changed header, whose own checksum is right.
  void write(detail::Header header) const {
    header.checksum = detail::checksum_of(header);
    std::string changed = bytes_;
    std::memcpy(changed.data(), &header, sizeof(header));
    write(changed);
  }
  // The store with a changed row of the catalogue or its entry of a face; all checksums are right.
  void write_catalogue(
      const std::function<void(detail::ViewpointRow&, detail::FaceEntries&)>& edit) {
    std::string changed = bytes_;
    detail::Header head = header();
    char* row_at = changed.data() + head.catalogue;
    char* faces_at = row_at + head.viewpoints * sizeof(detail::ViewpointRow);
    detail::ViewpointRow row;
    detail::FaceEntries faces;
    std::memcpy(&row, row_at, sizeof(row));
    std::memcpy(&faces, faces_at, sizeof(faces));
    edit(row, faces);
    std::memcpy(row_at, &row, sizeof(row));
    std::memcpy(faces_at, &faces, sizeof(faces));
    const std::size_t checked = head.file_bytes - head.graph_bytes - head.catalogue;
    head.catalogue_checksum = detail::checksum(
        image::bytes_of(std::string_view(changed).substr(head.catalogue, checked)));
    head.checksum = detail::checksum_of(head);
    std::memcpy(changed.data(), &head, sizeof(head));
    write(changed);
  }
  void expect_refused(const std::string& code) const {
    EXPECT_THAT([&] { Store::open(file_); },
                ThrowsMessage<InvalidInput>(
                    AllOf(HasSubstr("[" + code + "]"), HasSubstr("tiny.enfilade"))));
  }

  TemporaryFolder folder_{"store_damage"};
  fs::path file_;
  std::string bytes_;
};

// True if reading the whole store tells that something is wrong.
bool is_noticed(const fs::path& file) {
  try {
    return !Store::open(file)->verify(1).empty();
  } catch (const InvalidInput&) {
    return true;
  }
}

TEST_F(Damage, OfAnyBitIsNoticed) {
  ASSERT_FALSE(is_noticed(file_));
  for (std::size_t i = 0; i < bytes_.size(); ++i) {
    const auto flipped = static_cast<char>(bytes_[i] ^ (1 << i % 8));
    write_byte(i, flipped);
    EXPECT_TRUE(is_noticed(file_)) << "byte " << i << " of " << bytes_.size();
    write_byte(i, bytes_[i]);
  }
  EXPECT_FALSE(is_noticed(file_));
}

TEST_F(Damage, OfAFaceIsToldWhereItIsRead) {
  const auto store = Store::open(file_);
  detail::FaceEntries faces;
  std::memcpy(&faces, bytes_.data() + header().catalogue + 3 * sizeof(detail::ViewpointRow),
              sizeof(faces));
  for (std::size_t l = 0; l < kLayers; ++l) {
    const detail::FaceEntry& entry = faces[l * kCubeFaces + 3];
    for (std::uint64_t at = entry.offset; at < entry.offset + entry.all_bytes(); ++at) {
      write_byte(at, static_cast<char>(bytes_[at] ^ 16));
      const auto layer = static_cast<Layer>(l);
      const std::string where =
          "scan \"tiny\", viewpoint \"v0\", " + std::string(to_string(layer)) + ", face 3";
      // The mapping shows the change: no need to open it anew.
      EXPECT_THAT([&] { read_panorama(*store, ViewpointIndex(0)); },
                  ThrowsMessage<InvalidInput>(AllOf(HasSubstr("tiny.enfilade"), HasSubstr(where),
                                                    HasSubstr("bad-checksum"))));
      write_byte(at, bytes_[at]);
    }
    const std::vector<Diagnostic> faults = store->verify();
    EXPECT_TRUE(faults.empty());
  }
}

TEST_F(Damage, ByTruncationIsRefused) {
  for (std::size_t length = 0; length < bytes_.size(); length += 1 + length / 100) {
    write(bytes_.substr(0, length));
    EXPECT_THROW(Store::open(file_), InvalidInput) << length << " bytes";
  }
  write(bytes_ + '\0');
  expect_refused("truncated");
  fs::remove(file_);
  EXPECT_THROW(Store::open(file_), FileError);
  EXPECT_THROW(Store::open(folder_.path()), FileError);
}

TEST_F(Damage, OfTheHeaderHasItsReason) {
  detail::Header h = header();
  h.version = 2;
  write(h);
  expect_refused("wrong-version");
  h = header();
  h.byte_order = 0x04030201;
  write(h);
  expect_refused("wrong-byte-order");
  h = header();
  h.file_bytes = 0;
  write(h);
  expect_refused("unfinished");
  write(std::string(5000, 'x'));
  expect_refused("not-a-store");
}

TEST_F(Damage, ThatLiesAboutSizesIsRefusedThoughChecksumsAreRight) {
  constexpr std::uint64_t kHuge = ~std::uint64_t{0};
  for (const auto field : {&detail::Header::catalogue, &detail::Header::viewpoints,
                           &detail::Header::scan_bytes, &detail::Header::name_bytes,
                           &detail::Header::graph_bytes, &detail::Header::graph_json_bytes}) {
    for (const std::uint64_t wrong : {kHuge, kHuge / 896 + 1, header().file_bytes + 1}) {
      if (field == &detail::Header::graph_json_bytes && wrong == header().file_bytes + 1) continue;
      detail::Header h = header();
      h.*field = wrong;
      write(h);
      expect_refused("bad-index");
    }
  }
  // A size that only decompressing can tell to be wrong.
  detail::Header h = header();
  ++h.graph_json_bytes;
  write(h);
  EXPECT_THROW(Store::open(file_)->connectivity(), InvalidInput);
}

TEST_F(Damage, OfTheIndexIsRefusedThoughChecksumsAreRight) {
  using Row = detail::ViewpointRow;
  using Faces = detail::FaceEntries;
  const std::vector<std::function<void(Row&, Faces&)>> edits{
      [](Row& row, Faces&) { row.name_offset = 0xFFFFFFFF; },
      [](Row& row, Faces&) { row.name_bytes = 0; },
      [](Row& row, Faces&) { row.name_bytes = 0xFFFFFFFF; },
      [](Row& row, Faces&) { row.name_offset += 2; },  // v1's id
      [](Row& row, Faces&) { row.included = 2; },
      [](Row& row, Faces&) { row.position[1] = std::numeric_limits<double>::quiet_NaN(); },
      [](Row& row, Faces&) { row.sizes[0] = image::kLargestCellFace + 1; },
      [](Row& row, Faces&) { row.sizes[3] = 0; },
      [](Row&, Faces& faces) { faces[0].offset = 100; },
      [](Row&, Faces& faces) { faces[0].offset = ~std::uint64_t{0}; },
      [](Row&, Faces& faces) { faces[5].bytes = 0xFFFFFFFF; },
      [](Row&, Faces& faces) { faces[5].border_bytes = 0xFFFFFFFF; },
      [](Row&, Faces& faces) { faces[6].border_bytes = 1; },
      [](Row&, Faces& faces) { faces[1].coding = detail::Coding::kRawRgb; },
      [](Row&, Faces& faces) { faces[1].coding = detail::Coding::kPlain; },
      [](Row&, Faces& faces) { faces[7].coding = detail::Coding::kJpeg; },
      [](Row&, Faces& faces) { faces[23].coding = static_cast<detail::Coding>(20); },
      [](Row&, Faces& faces) { faces[9] = {}; },
  };
  for (std::size_t i = 0; i < edits.size(); ++i) {
    SCOPED_TRACE(i);
    write_catalogue(edits[i]);
    expect_refused("bad-index");
  }
  write_catalogue([](Row& row, Faces&) { row.world_from_panorama[0] = 2; });
  expect_refused("bad-pose");
}

TEST_F(Damage, ThatOnlyDecodingCanTellIsRefusedThere) {
  // Sizes that the faces' bytes don't have.
  write_catalogue([](detail::ViewpointRow& row, detail::FaceEntries&) {
    row.sizes = {5, 5, 5, 5};
  });
  const auto store = Store::open(file_);
  for (const int layer : {0, 1, 2, 3}) {
    EXPECT_THAT(
        [&] { read_panorama(*store, ViewpointIndex(0), static_cast<LayerMask>(1 << layer)); },
        ThrowsMessage<InvalidInput>(AllOf(HasSubstr("damaged-face"), HasSubstr("\"v0\""))));
  }
  EXPECT_FALSE(store->verify().empty());
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
