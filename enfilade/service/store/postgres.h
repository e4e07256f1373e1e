/// \file  A database of a PostgreSQL server, by libpq.
#pragma once
#include <memory>
#include <string>

#include "enfilade/service/store/connection.h"

namespace enfilade::service::store {

/// Connects to a URL as libpq reads it; missing parts come from libpq's environment and files
/// (PGPASSWORD, ~/.pgpass).
/// \throws FileError if the server cannot be reached, refuses, or has a database of another
/// encoding than UTF-8; also if this build has no PostgreSQL. No message has a password
std::unique_ptr<Connection> connect_to_postgres(const std::string& url);

}  // namespace enfilade::service::store
