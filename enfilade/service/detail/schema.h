/// \file  The tables, as the steps that make them.
#pragma once
#include <array>

namespace enfilade::service::detail {

/// Migration k takes a database of version k to version k + 1. Those that were released stay as
/// they are: a change is a new one at the end. Times are seconds since 1970.
inline constexpr std::array<const char*, 1> kMigrations{R"sql(
CREATE TABLE team (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL UNIQUE COLLATE NOCASE,
  contact TEXT NOT NULL,
  created INTEGER NOT NULL
) STRICT;

CREATE TABLE token (
  id INTEGER PRIMARY KEY,
  hash TEXT NOT NULL UNIQUE,
  role TEXT NOT NULL CHECK (role IN ('team', 'organiser')),
  team INTEGER REFERENCES team (id),
  label TEXT NOT NULL,
  created INTEGER NOT NULL,
  expires INTEGER,
  revoked INTEGER,
  CHECK ((role = 'team') = (team IS NOT NULL))
) STRICT;

CREATE TABLE session (
  hash TEXT PRIMARY KEY,
  token INTEGER NOT NULL REFERENCES token (id),
  expires INTEGER NOT NULL
) STRICT;

CREATE TABLE submission (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  team INTEGER NOT NULL REFERENCES team (id),
  phase TEXT NOT NULL,
  method TEXT NOT NULL,
  created INTEGER NOT NULL,
  state TEXT NOT NULL CHECK (state IN ('queued', 'scored', 'failed', 'withdrawn')),
  digest TEXT NOT NULL,
  content BLOB NOT NULL,
  score TEXT,
  finished INTEGER
) STRICT;
CREATE INDEX submission_team ON submission (team, phase, created);
CREATE INDEX submission_phase ON submission (phase, state);
)sql"};

}  // namespace enfilade::service::detail
