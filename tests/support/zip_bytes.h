/// \file  Zip files for tests, made in memory.
#pragma once
#include <gtest/gtest.h>
#include <zip.h>

#include <string>
#include <utility>
#include <vector>

namespace enfilade::scan::testing {

struct ZipEntry {
  std::string path, content;
  std::string password = "";  ///< encrypts the entry
};

/// The bytes of a zip file of these, deflated.
inline std::string zip_of(const std::vector<ZipEntry>& entries) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* memory = zip_source_buffer_create(nullptr, 0, 0, &error);
  zip_source_keep(memory);
  zip_t* zip = zip_open_from_source(memory, ZIP_TRUNCATE, &error);
  EXPECT_NE(zip, nullptr);
  for (const ZipEntry& entry : entries) {
    zip_source_t* content = zip_source_buffer(zip, entry.content.data(), entry.content.size(), 0);
    const zip_int64_t at = zip_file_add(zip, entry.path.c_str(), content, ZIP_FL_ENC_UTF_8);
    EXPECT_GE(at, 0) << entry.path;
    if (!entry.password.empty()) {
      EXPECT_EQ(zip_file_set_encryption(zip, static_cast<zip_uint64_t>(at), ZIP_EM_AES_256,
                                        entry.password.c_str()),
                0);
    }
  }
  EXPECT_EQ(zip_close(zip), 0);
  std::string bytes;
  zip_stat_t stat;
  EXPECT_EQ(zip_source_stat(memory, &stat), 0);
  bytes.resize(stat.size);
  EXPECT_EQ(zip_source_open(memory), 0);
  EXPECT_EQ(zip_source_read(memory, bytes.data(), bytes.size()),
            static_cast<zip_int64_t>(bytes.size()));
  zip_source_close(memory);
  zip_source_free(memory);
  zip_error_fini(&error);
  return bytes;
}

}  // namespace enfilade::scan::testing
