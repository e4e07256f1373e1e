/// \file  Tables in Apache Parquet's files, as far as LeRobot needs them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace enfilade::exports::detail {

/// Lists of equally many numbers, a list a row.
struct FloatLists {
  std::size_t columns = 1;    ///< numbers a row, 1 or more
  std::vector<float> values;  ///< row after row
};
/// Pictures, as Hugging Face's `datasets` has them: a group of `bytes` and `path`.
struct PictureCells {
  std::vector<std::string> bytes, paths;  ///< one each a row
};

/// A column: no cell is missing. In the file they could be (all fields are optional).
struct ParquetColumn {
  std::string name;
  std::variant<std::vector<std::int64_t>, std::vector<float>, FloatLists, PictureCells> cells;
};

/// A file of one row group, neither packed nor encoded (PLAIN), with a page a column. Source:
/// apache/parquet-format, README, Encodings and parquet.thrift (the compact protocol).
/// \param metadata  pairs for the reader
/// \throws ArgumentError if columns differ in their rows, or a column is above 2 GiB
std::string parquet_file(const std::vector<ParquetColumn>& columns,
                         const std::vector<std::pair<std::string, std::string>>& metadata);

}  // namespace enfilade::exports::detail
