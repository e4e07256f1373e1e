#include "enfilade/features/formats/hdf5_filters.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <utility>

#include "enfilade/core/names.h"

namespace enfilade::features::formats {
namespace {

// Numbers that The HDF Group gave out ("Registered Filter Plugins").
constexpr H5Z_filter_t kLzf = 32000;
constexpr std::array<std::pair<H5Z_filter_t, const char*>, 10> kNames{{{H5Z_FILTER_SZIP, "szip"},
                                                                       {kLzf, "lzf"},
                                                                       {307, "bzip2"},
                                                                       {32001, "blosc"},
                                                                       {32004, "lz4"},
                                                                       {32008, "bitshuffle"},
                                                                       {32013, "zfp"},
                                                                       {32015, "zstd"},
                                                                       {32017, "sz"},
                                                                       {32026, "blosc2"}}};

// More bytes than any chunk has that Hdf5Source::check_layout() accepts: 2^24 numbers of 64 bits.
constexpr std::size_t kMostBytes = std::size_t{1} << 27;

// Whether LZF unpacks to whole chunks. As all of HDF5, for the holder of Hdf5Library alone.
bool& expects_whole_chunks() {
  static bool whole = true;
  return whole;
}

// The library's interface of filters. Gives 0 for damaged bytes; *buffer then stays the library's.
std::size_t unpack_chunk(unsigned flags, std::size_t count, const unsigned* values,
                         std::size_t bytes, std::size_t* buffer_bytes, void** buffer) {
  if ((flags & H5Z_FLAG_REVERSE) == 0) return 0;
  constexpr std::size_t kChunkBytes = 2;  // where h5py puts the size of a chunk
  const std::size_t room = count > kChunkBytes ? values[kChunkBytes] : 0;
  if (room == 0 || room > kMostBytes) return 0;
  void* const unpacked = H5allocate_memory(room, false);
  if (unpacked == nullptr) return 0;
  const auto written = unpack_lzf({static_cast<const std::byte*>(*buffer), bytes},
                                  {static_cast<std::byte*>(unpacked), room});
  if (!written || *written == 0 || (expects_whole_chunks() && *written != room)) {
    H5free_memory(unpacked);
    return 0;
  }
  H5free_memory(*buffer);
  *buffer = unpacked;
  *buffer_bytes = room;
  return *written;
}

}  // namespace

std::optional<std::size_t> unpack_lzf(std::span<const std::byte> packed, std::span<std::byte> to) {
  constexpr std::size_t kLongestRun = 32;  // of literals; a larger first byte is a repetition
  std::size_t at = 0, written = 0;
  const auto next = [&] { return std::to_integer<std::size_t>(packed[at++]); };
  while (at < packed.size()) {
    const std::size_t control = next();
    if (control < kLongestRun) {
      const std::size_t length = control + 1;
      if (length > packed.size() - at || length > to.size() - written) return std::nullopt;
      std::memcpy(to.data() + written, packed.data() + at, length);
      at += length;
      written += length;
      continue;
    }
    // The upper three bits are the length less 2, or 7 with more in the next byte. Then thirteen
    // bits say how far back to begin.
    std::size_t length = control >> 5U;
    if (length == 7) {
      if (at == packed.size()) return std::nullopt;
      length += next();
    }
    length += 2;
    if (at == packed.size()) return std::nullopt;
    const std::size_t back = ((control & 31U) << 8U) + next() + 1;
    if (back > written || length > to.size() - written) return std::nullopt;
    // Byte by byte: a repetition may overlap itself.
    for (std::size_t i = 0; i < length; ++i, ++written) to[written] = to[written - back];
  }
  return written;
}

void register_lzf() {
  H5Z_class2_t filter{};
  filter.version = H5Z_CLASS_T_VERS;
  filter.id = kLzf;
  filter.decoder_present = 1;
  filter.name = "lzf";
  filter.filter = unpack_chunk;
  H5Zregister(&filter);
}

void expect_chunks_of(hid_t made) {
  const auto has = [made](H5Z_filter_t id) {
    unsigned flags = 0;
    std::size_t values = 0;
    return H5Pget_filter_by_id2(made, id, &flags, &values, nullptr, 0, nullptr, nullptr) >= 0;
  };
  expects_whole_chunks() = !has(H5Z_FILTER_NBIT) && !has(H5Z_FILTER_SCALEOFFSET);
}

std::optional<std::string> missing_filter(hid_t made) {
  const int filters = H5Pget_nfilters(made);
  for (int i = 0; i < filters; ++i) {
    unsigned flags = 0, configuration = 0;
    std::size_t values = 0;
    std::array<char, 64> name{};
    const H5Z_filter_t id = H5Pget_filter2(made, static_cast<unsigned>(i), &flags, &values, nullptr,
                                           name.size(), name.data(), &configuration);
    if (id < 0 || H5Zfilter_avail(id) > 0) continue;
    std::string_view shown(name.data(), strnlen(name.data(), name.size()));
    const auto known = std::ranges::find(kNames, id, &std::pair<H5Z_filter_t, const char*>::first);
    if (known != kNames.end()) shown = known->second;
    return fmt::format("{} ({})", quote(shown), id);
  }
  return std::nullopt;
}

}  // namespace enfilade::features::formats
