/// \file  From a file of SQLite into a database of PostgreSQL.
#pragma once
#include <cstdint>
#include <string>

#include "enfilade/core/progress.h"

namespace enfilade::service::store {

/// Copies all rows of a file into a database that has none, in one transaction: all are there when
/// this returns, or none if it throws. The file's schema is brought up to date, and nobody else can
/// change it meanwhile. New rows get ids that the file has never given.
/// \param progress is told of rows \returns how many rows there were
/// \throws FileError for a place that cannot be opened, or a database that has rows; Error naming
/// the table where a row cannot be kept
std::int64_t transfer(const std::string& file, const std::string& url, const Progress& progress);

}  // namespace enfilade::service::store
