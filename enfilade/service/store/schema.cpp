// The tables of the database.

#include "enfilade/service/store/database.h"

namespace enfilade::service::store {

const std::array<const char*, 8> kMigrations{
    // 1: evaluation
    R"sql(
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
)sql",
    // 2: collections. SQLite can't change a CHECK: token, and session which refers to it, are
    // created again.
    R"sql(
CREATE TABLE collection (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL UNIQUE,
  title TEXT NOT NULL,
  kind TEXT NOT NULL CHECK (kind IN ('write', 'walk')),
  open INTEGER NOT NULL CHECK (open IN (0, 1)),
  link_key TEXT NOT NULL,
  platform TEXT NOT NULL CHECK (platform IN ('self', 'mturk', 'prolific')),
  origins TEXT NOT NULL,  -- a line each
  completion_code TEXT NOT NULL,
  consent TEXT NOT NULL,
  instructions TEXT NOT NULL,
  per_item INTEGER NOT NULL,
  lease_seconds INTEGER NOT NULL,
  tasks_per_visit INTEGER NOT NULL,  -- 0: no end
  created INTEGER NOT NULL
) STRICT;

CREATE TABLE item (  -- a path to describe, or an instruction to walk; given out by rising id
  id INTEGER PRIMARY KEY,
  collection INTEGER NOT NULL REFERENCES collection (id),
  split TEXT NOT NULL,
  path_id INTEGER NOT NULL,
  number INTEGER NOT NULL,  -- of the instruction; 0 for write
  scan TEXT NOT NULL,
  heading REAL NOT NULL,
  path TEXT NOT NULL,  -- viewpoints, a line each
  distance REAL,
  instruction TEXT NOT NULL,  -- to walk; '' for write
  secret INTEGER NOT NULL,    -- its goal
  state TEXT NOT NULL CHECK (state IN ('fresh', 'begun', 'complete')),
  UNIQUE (collection, path_id, number)
) STRICT;
CREATE INDEX item_state ON item (collection, state, id);

CREATE TABLE worker (
  id INTEGER PRIMARY KEY,
  collection INTEGER NOT NULL REFERENCES collection (id),
  external TEXT NOT NULL,
  consented INTEGER,
  created INTEGER NOT NULL,
  UNIQUE (collection, external)
) STRICT;

CREATE TABLE visit (
  id INTEGER PRIMARY KEY,
  worker INTEGER NOT NULL REFERENCES worker (id),
  external TEXT NOT NULL,  -- assignment or session of the platform
  grouped TEXT NOT NULL,   -- HIT or study
  submit_to TEXT NOT NULL,
  created INTEGER NOT NULL,
  UNIQUE (worker, external)
) STRICT;

CREATE TABLE task (  -- an item with a worker, who gets no item twice
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  item INTEGER NOT NULL REFERENCES item (id),
  worker INTEGER NOT NULL REFERENCES worker (id),
  visit INTEGER NOT NULL REFERENCES visit (id),
  state TEXT NOT NULL
    CHECK (state IN ('leased', 'returned', 'lapsed', 'submitted', 'accepted', 'rejected')),
  expires INTEGER NOT NULL,  -- of the lease
  draft TEXT NOT NULL DEFAULT '',
  content TEXT NOT NULL DEFAULT '',  -- the instruction, or a walk's steps
  digest TEXT NOT NULL DEFAULT '',   -- of what was handed in, whatever reviewers changed since
  seconds REAL NOT NULL DEFAULT 0,
  flags TEXT NOT NULL DEFAULT '',  -- a line each
  camera TEXT NOT NULL DEFAULT '',
  error REAL,  -- of a walk, metres
  submitted INTEGER NOT NULL DEFAULT 0,
  reason TEXT NOT NULL DEFAULT '',
  UNIQUE (item, worker)
) STRICT;
CREATE INDEX task_worker ON task (worker);
CREATE INDEX task_visit ON task (visit);
CREATE INDEX task_state ON task (state);

CREATE TABLE event (  -- what reviewers did
  id INTEGER PRIMARY KEY,
  task INTEGER NOT NULL REFERENCES task (id),
  at INTEGER NOT NULL,
  who TEXT NOT NULL,
  what TEXT NOT NULL CHECK (what IN ('edited', 'accepted', 'rejected')),
  before TEXT NOT NULL,
  reason TEXT NOT NULL
) STRICT;
CREATE INDEX event_task ON event (task);

CREATE TABLE token_2 (
  id INTEGER PRIMARY KEY,
  hash TEXT NOT NULL UNIQUE,
  role TEXT NOT NULL CHECK (role IN ('team', 'organiser', 'reviewer', 'worker')),
  team INTEGER REFERENCES team (id),
  visit INTEGER REFERENCES visit (id),
  label TEXT NOT NULL,
  created INTEGER NOT NULL,
  expires INTEGER,
  revoked INTEGER,
  CHECK ((role = 'team') = (team IS NOT NULL)),
  CHECK ((role = 'worker') = (visit IS NOT NULL))
) STRICT;
INSERT INTO token_2 (id, hash, role, team, label, created, expires, revoked)
  SELECT id, hash, role, team, label, created, expires, revoked FROM token;
CREATE TABLE session_2 (
  hash TEXT PRIMARY KEY,
  token INTEGER NOT NULL REFERENCES token_2 (id),
  expires INTEGER NOT NULL
) STRICT;
INSERT INTO session_2 SELECT hash, token, expires FROM session;
DROP TABLE session;
DROP TABLE token;
ALTER TABLE token_2 RENAME TO token;
ALTER TABLE session_2 RENAME TO session;
CREATE INDEX token_worker ON token (expires) WHERE role = 'worker';
)sql",
    // 3: secret goals. Teams that were there before are not approved: one person may have made
    // thirty. Collections: the order of tasks, questions, times by the server's clock.
    R"sql(
ALTER TABLE team ADD COLUMN approved INTEGER;  -- when; NULL: it is not
ALTER TABLE submission ADD COLUMN shown REAL;  -- primary metric that a ladder showed
ALTER TABLE submission ADD COLUMN ends BLOB;   -- evaluation/near_copies.h
ALTER TABLE submission ADD COLUMN near_copy_of INTEGER REFERENCES submission (id);
ALTER TABLE submission ADD COLUMN differing INTEGER;  -- episodes that end elsewhere than in that
ALTER TABLE submission ADD COLUMN paper TEXT NOT NULL DEFAULT '';  -- https addresses
ALTER TABLE submission ADD COLUMN code TEXT NOT NULL DEFAULT '';

CREATE TABLE attempt (  -- a file that was checked
  id INTEGER PRIMARY KEY,
  team INTEGER NOT NULL REFERENCES team (id),
  phase TEXT NOT NULL,
  address TEXT NOT NULL,  -- a hash with a key
  created INTEGER NOT NULL,
  submission INTEGER REFERENCES submission (id)  -- NULL: it was refused
) STRICT;
CREATE INDEX attempt_address ON attempt (address, phase, created);
CREATE INDEX attempt_refused ON attempt (phase, team, created) WHERE submission IS NULL;

CREATE TABLE phase_end (  -- phases with secret goals whose last scores were shown
  phase TEXT PRIMARY KEY,
  at INTEGER NOT NULL
) STRICT;

CREATE TABLE secret (
  name TEXT PRIMARY KEY,
  value TEXT NOT NULL
) STRICT;

ALTER TABLE collection ADD COLUMN archived INTEGER;  -- when; NULL: it is not
ALTER TABLE collection ADD COLUMN seed INTEGER NOT NULL DEFAULT 0;  -- of the order of tasks
ALTER TABLE collection ADD COLUMN pay TEXT NOT NULL DEFAULT '';
ALTER TABLE collection ADD COLUMN minutes REAL NOT NULL DEFAULT 0;  -- a task takes; 0: not said
ALTER TABLE collection ADD COLUMN check_every INTEGER NOT NULL DEFAULT 3;
ALTER TABLE collection ADD COLUMN screen_out_code TEXT NOT NULL DEFAULT '';
ALTER TABLE collection ADD COLUMN consent_changed INTEGER NOT NULL DEFAULT 0;

ALTER TABLE item ADD COLUMN practice INTEGER NOT NULL DEFAULT 0;
ALTER TABLE item ADD COLUMN block INTEGER NOT NULL DEFAULT 0;  -- collecting/order.h
UPDATE item SET block = id / 20;
CREATE INDEX item_open ON item (collection, practice, block) WHERE state <> 'complete';

ALTER TABLE task ADD COLUMN leased INTEGER NOT NULL DEFAULT 0;  -- at first; 0: it was not kept

CREATE TABLE question (
  id INTEGER PRIMARY KEY,
  collection INTEGER NOT NULL REFERENCES collection (id),
  stage TEXT NOT NULL CHECK (stage IN ('screening', 'check')),
  text TEXT NOT NULL,
  choices TEXT NOT NULL,  -- a line each
  accepted TEXT NOT NULL  -- those of the choices that are right
) STRICT;
CREATE INDEX question_collection ON question (collection);

CREATE TABLE answer (
  question INTEGER NOT NULL REFERENCES question (id),
  worker INTEGER NOT NULL REFERENCES worker (id),
  choice TEXT NOT NULL,
  accepted INTEGER NOT NULL,
  at INTEGER NOT NULL,
  PRIMARY KEY (worker, question)
) STRICT;
)sql",
    // 4: more kinds of collections. A column's own CHECK goes with the column, so kind is made
    // anew.
    R"sql(
ALTER TABLE collection ADD COLUMN kind_2 TEXT NOT NULL DEFAULT 'write'
  CHECK (kind_2 IN ('write', 'walk', 'describe', 'find', 'guide', 'dialogue'));
UPDATE collection SET kind_2 = kind;
ALTER TABLE collection DROP COLUMN kind;
ALTER TABLE collection RENAME COLUMN kind_2 TO kind;
ALTER TABLE collection ADD COLUMN language TEXT NOT NULL DEFAULT 'en-US';  -- of guide

ALTER TABLE item ADD COLUMN object INTEGER;                      -- to describe or to find
ALTER TABLE item ADD COLUMN target TEXT NOT NULL DEFAULT '';     -- what people call it
ALTER TABLE item ADD COLUMN region TEXT NOT NULL DEFAULT '';     -- viewpoints, a line each
ALTER TABLE item ADD COLUMN outlines TEXT NOT NULL DEFAULT '';   -- collecting/kinds/outlines.h
ALTER TABLE item ADD COLUMN of INTEGER REFERENCES task (id);     -- whose text is verified
CREATE INDEX item_of ON item (of) WHERE of IS NOT NULL;

ALTER TABLE task ADD COLUMN role TEXT NOT NULL DEFAULT '';  -- in a dialogue

CREATE TABLE dialogue (  -- of two tasks of one item
  id INTEGER PRIMARY KEY,
  item INTEGER NOT NULL REFERENCES item (id),
  navigator INTEGER REFERENCES task (id),  -- NULL: nobody has sat there yet
  oracle INTEGER REFERENCES task (id),
  finished INTEGER  -- when
) STRICT;
CREATE INDEX dialogue_item ON dialogue (item);
CREATE INDEX dialogue_navigator ON dialogue (navigator);
CREATE INDEX dialogue_oracle ON dialogue (oracle);

CREATE TABLE turn (  -- what was said and done in a dialogue, by rising id
  id INTEGER PRIMARY KEY,
  dialogue INTEGER NOT NULL REFERENCES dialogue (id),
  role TEXT NOT NULL CHECK (role IN ('navigator', 'oracle')),
  text TEXT NOT NULL,       -- '' of a step
  viewpoint TEXT NOT NULL,  -- where the navigator stands then
  heading REAL NOT NULL,
  elevation REAL NOT NULL,
  at INTEGER NOT NULL
) STRICT;
CREATE INDEX turn_dialogue ON turn (dialogue, id);
)sql",
    // 5: sessions of the arena
    R"sql(
CREATE TABLE play (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  hash TEXT NOT NULL,  -- of the key of who has begun it
  task TEXT NOT NULL,
  split TEXT NOT NULL,
  episode TEXT NOT NULL,  -- an instruction's id
  steps INTEGER NOT NULL,  -- limits
  mistakes INTEGER NOT NULL,
  touched INTEGER NOT NULL
) STRICT;
CREATE INDEX play_touched ON play (touched);

CREATE TABLE play_call (  -- by which a play is walked again
  play INTEGER NOT NULL REFERENCES play (id),
  number INTEGER NOT NULL,
  tool TEXT NOT NULL,
  argument TEXT NOT NULL,
  fault TEXT NOT NULL,  -- why no call could be read; '': one was
  PRIMARY KEY (play, number)
) STRICT, WITHOUT ROWID;
)sql",
    // 6: names of teams by their lower case, which PostgreSQL has no NOCASE for; places of items
    R"sql(
CREATE UNIQUE INDEX team_name ON team (lower(name));
CREATE INDEX task_place ON task (item, state, expires);
)sql",
    // 7: what phases have given away of their goals, also under former names and rules
    R"sql(
CREATE TABLE phase_rule (  -- how a phase with secret goals showed scores
  id INTEGER PRIMARY KEY,
  phase TEXT NOT NULL,
  rule TEXT NOT NULL,         -- evaluation/ledger.cpp
  digest TEXT NOT NULL,       -- of its goals
  goals BLOB NOT NULL,        -- goal_keys.h, 8 bytes each
  levels INTEGER NOT NULL,    -- values that its ladder can show; 0: it has none
  means_bits REAL NOT NULL,   -- of a row
  rows_shown INTEGER,         -- when at first; NULL: they are not
  UNIQUE (phase, rule, digest)
) STRICT;
ALTER TABLE submission ADD COLUMN rule INTEGER REFERENCES phase_rule (id);  -- it was scored by
CREATE INDEX submission_rule ON submission (rule);
)sql",
    // 8: what a team tells of its method
    R"sql(
ALTER TABLE submission ADD COLUMN description TEXT NOT NULL DEFAULT '';  -- Markdown
ALTER TABLE submission ADD COLUMN bibtex TEXT NOT NULL DEFAULT '';
ALTER TABLE submission ADD COLUMN weights TEXT NOT NULL DEFAULT 'unsaid'
  CHECK (weights IN ('unsaid', 'open', 'closed'));
ALTER TABLE submission ADD COLUMN walks_public INTEGER NOT NULL DEFAULT 0;  -- everybody sees its trajectories
)sql"};

}  // namespace enfilade::service::store
