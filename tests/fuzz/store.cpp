// Any bytes are refused as a store or read to the end, also where somebody has put the checksums
// right. Offsets below are those of docs/store.md, not taken from the library's own headers.
#include <xxhash.h>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/scan/store.h"
#include "tests/fuzz/memory_file.h"

namespace {

using namespace enfilade;
using Bytes = std::vector<std::uint8_t>;

template <class T = std::uint64_t>
T get(const Bytes& bytes, std::uint64_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

void put(Bytes& bytes, std::uint64_t at, std::uint64_t value) {
  std::memcpy(bytes.data() + at, &value, sizeof(value));
}

constexpr std::uint64_t kHeader = 128, kRow = 128, kEntry = 32, kEntries = 24;

void repair_faces(Bytes& bytes, std::uint64_t faces, std::uint64_t viewpoints) {
  for (std::uint64_t i = 0; i < viewpoints * kEntries; ++i) {
    const std::uint64_t entry = faces + i * kEntry;
    const auto offset = get(bytes, entry);
    const std::uint64_t size =
        std::uint64_t{get<std::uint32_t>(bytes, entry + 8)} + get<std::uint32_t>(bytes, entry + 12);
    if (size == 0 || offset > bytes.size() || size > bytes.size() - offset) continue;
    put(bytes, entry + 24, XXH3_64bits(bytes.data() + offset, size));
  }
}

// Puts the file's size and all checksums right that can be found.
void repair(Bytes& bytes) {
  if (bytes.size() < kHeader) return;
  put(bytes, 16, bytes.size());
  const auto catalogue = get(bytes, 32), viewpoints = get(bytes, 40), names = get(bytes, 56),
             graph = get(bytes, 64);
  if (catalogue <= bytes.size() && graph <= bytes.size() - catalogue &&
      viewpoints <= bytes.size() / (kRow + kEntries * kEntry)) {
    const std::uint64_t tables = viewpoints * (kRow + kEntries * kEntry);
    if (names <= bytes.size() && catalogue + tables + names + graph == bytes.size()) {
      repair_faces(bytes, catalogue + viewpoints * kRow, viewpoints);
      put(bytes, 80, XXH3_64bits(bytes.data() + bytes.size() - graph, graph));
      put(bytes, 88, XXH3_64bits(bytes.data() + catalogue, tables + names));
    }
  }
  put(bytes, 120, XXH3_64bits(bytes.data(), 120));
}

// Larger faces only take longer.
constexpr std::uint32_t kLargestFace = 128;

void read_panoramas(const scan::PanoramaSource& store) {
  for (std::size_t i = 0; i < store.size(); ++i) {
    const scan::FaceSizes sizes = store.face_sizes(ViewpointIndex(i));
    for (std::size_t layer = 0; layer < scan::kLayers; ++layer) {
      if (sizes[layer] > kLargestFace) continue;
      try {
        const auto mask = static_cast<scan::LayerMask>(1 << layer);
        const auto read = read_panorama(store, ViewpointIndex(i), mask).sizes();
        EN_CHECK_EQ(read[layer], sizes[layer]);
      } catch (const Error&) {
      }
    }
  }
}

void read(const Bytes& bytes) {
  const fuzz::MemoryFile file(bytes.data(), bytes.size());
  try {
    const auto store = scan::Store::open(file.path());
    read_panoramas(*store);
    store->verify(1);
    EN_CHECK_EQ(store->connectivity().entries.size(), store->size());
  } catch (const Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, data + size);
  read(bytes);
  repair(bytes);
  read(bytes);
  return 0;
}
