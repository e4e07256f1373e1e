/// \file  From a file of SQLite into a database of PostgreSQL.
#pragma once
#include <cstdint>
#include <string>

#include "enfilade/core/progress.h"

namespace enfilade::service::store {

/// Copies all rows of a file into a database without rows, in one transaction: all are there when
/// this returns, or none if it throws. The file's schema is brought up to date, and no other
/// process can change it meanwhile. New rows get ids that the file has never given.
/// \param progress is called with rows
/// \returns the number of rows
/// \throws FileError for a place that cannot be opened, or a database that has rows
/// \throws Error naming the table of a row that cannot be stored
std::int64_t transfer(const std::string& file, const std::string& url, const Progress& progress);

}  // namespace enfilade::service::store
