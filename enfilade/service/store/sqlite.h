/// \file  A database in a file: SQLite in WAL mode.
#pragma once
#include <filesystem>
#include <memory>

#include "enfilade/service/store/connection.h"

namespace enfilade::service::store {

/// Opens a file, and makes it if it is missing. Only its owner may read it then: it has people's
/// texts and secret goals. An existing file that others may read is closed to them.
/// \throws FileError if it can't be opened or written, or others may read it and that can't be
/// changed
std::unique_ptr<Connection> open_sqlite(const std::filesystem::path& file);

/// Copies a file's database, also while a server uses it. The copy is written beside its
/// destination and then renamed, so that it is never there in part. An older copy of that name is
/// replaced. Only its owner may read it.
/// \throws FileError naming the file that cannot be opened, read or written
void back_up(const std::filesystem::path& database, const std::filesystem::path& copy);

}  // namespace enfilade::service::store
