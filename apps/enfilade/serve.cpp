// enfilade serve: a data set, its viewer and its evaluation over HTTP.
#include "enfilade/service/server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <malloc.h>
#include <netinet/in.h>
#include <semaphore.h>
#include <sys/socket.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "apps/common/program.h"
#include "apps/enfilade/home_pictures.h"
#include "apps/enfilade/verbs.h"
#include "enfilade/agents/run.h"
#include "enfilade/service/client.h"
#include "enfilade/service/site.h"
#include "enfilade/tasks/results.h"

namespace enfilade::apps::serve_verb {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string data, database, phases, log, organiser;
  std::uint32_t faces = 1024;  // texels, of a first visit's homes
  service::ServerConfig config;
};

void print_json(const service::RequestRecord& record) {
  nlohmann::ordered_json line{{"address", record.address}, {"method", record.method},
                              {"path", record.path},       {"status", record.status},
                              {"bytes", record.bytes},     {"seconds", record.seconds}};
  if (!record.who.empty()) line["who"] = record.who;
  if (!record.fault.empty()) line["fault"] = record.fault;
  say(stderr, "{}\n", line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

void print_text(const service::RequestRecord& record) {
  say(stderr, "{} {} {:?} {} {} B {:.1f} ms{}{}\n", record.address, record.method, record.path,
      record.status, record.bytes, record.seconds * 1000,
      record.fault.empty() ? "" : " fault: ", record.fault);
}

std::function<void(const service::RequestRecord&)> log_of(const std::string& kind) {
  if (kind == "none") return {};  // "" is "text"
  return [kind](const service::RequestRecord& record) {
    static std::mutex one_line_at_a_time;
    const std::scoped_lock lock(one_line_at_a_time);
    kind == "json" ? print_json(record) : print_text(record);
  };
}

// glibc gives threads heaps of their own, and freed memory stays in its heap: with 64 threads,
// each large submission took another 20 MB. Two heaps keep that below 100 MB in all.
void share_heaps() {
#ifdef __GLIBC__
  mallopt(M_ARENA_MAX, 2);
#endif
}

/// What --db names, else the environment, else `otherwise`.
std::string database_of(const std::string& given, const std::string& otherwise = {}) {
  if (service::has_password(given)) {
    throw UsageError(
        "--db: has a password, which everybody on this machine could read; leave it out, and let "
        "PGPASSWORD, ~/.pgpass or ENFILADE_DATABASE (with the whole address) have it");
  }
  if (!given.empty()) return given;
  const char* named = std::getenv("ENFILADE_DATABASE");
  if (named != nullptr && *named != '\0') return named;
  if (otherwise.empty()) throw UsageError("--db: which database? ENFILADE_DATABASE names none");
  return otherwise;
}

/// For a user who has just started a server, perhaps the first of their life.
void print_first_steps(const Options& options, const std::string& address) {
  constexpr int kDays = 1;
  const std::string token = service::create_token(
      options.config.database, service::TokenRole::kOrganiser, options.organiser, kDays);
  say("\n"
      "You are its organiser. Log in by this link, which is valid for a day:\n"
      "  {0}organise#token={1}\n"
      "\n"
      "What to do next:\n"
      "  look around                     {0}\n"
      "  see how agents compare          {0}leaderboard\n"
      "  have people describe paths      {0}organise\n"
      "  submit results of an agent      {0}submit\n"
      "  serve a data set of yours       enfilade serve DATA\n"
      "  let others reach it             docs/service_operating.md\n"
      "Ctrl-C ends it. What was submitted and collected stays in {2}\n",
      address, token, service::shown_database(options.config.database));
}

/// Nobody who named no data set waits for one to be made, only to read that the port is taken.
void check_port_is_free(const service::ServerConfig& config) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(config.port));
  if (inet_pton(AF_INET, config.host.c_str(), &address.sin_addr) != 1 || config.port == 0) return;
  const int probe = ::socket(AF_INET, SOCK_STREAM, 0);
  const bool taken = ::connect(probe, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  ::close(probe);
  if (taken) {
    throw ArgumentError(fmt::format("{}:{}: another program listens there; choose another --port",
                                    config.host, config.port));
  }
}

// Written after everything else of a set of homes without a test split.
bool is_complete(const fs::path& homes) {
  return fs::exists(homes / "r2r" / "R2R_val_unseen.json");
}

struct FirstAgent {
  const char* name;  // as agents::make_agent()
  const char* team;
  const char* method;
};
constexpr std::array<FirstAgent, 2> kAgents{
    {{"shortest", "Baseline: Shortest", "Shortest path, told the goals (SYNTHETIC homes)"},
     {"random", "Baseline: Random", "Random heading, then five moves (SYNTHETIC homes)"}}};

// The token of a new team, or of the one that an earlier start has made.
std::string token_of(const std::string& database, const std::string& team) {
  constexpr int kDays = 1;
  try {
    return service::create_team(database, team);
  } catch (const FileError&) {
    throw;
  } catch (const Error&) {
    return service::create_token(database, service::TokenRole::kTeam, team, kDays);
  }
}

void wait_until_scored(service::Client& client, std::int64_t submission) {
  constexpr std::chrono::milliseconds kPause{20};
  constexpr int kMostPauses = 1500;  // half a minute
  for (int k = 0; k < kMostPauses && client.status(submission).state == "queued"; ++k) {
    std::this_thread::sleep_for(kPause);
  }
}

// How far a set of homes is: a bar, or without a terminal a line for each home that is made.
homes::SetProgress told_homes(std::size_t homes) {
  return [homes, bar = progress_bar("model homes"), told = std::size_t{0}](
             const std::string&, std::size_t done, std::size_t total) mutable {
    if (bar) return bar(done, total);
    for (; told < done * homes / total; ++told) say("home {} of {} is made\n", told + 1, homes);
    std::fflush(stdout);
  };
}

// What the first page waits for: less than a minute of two cores for both homes.
constexpr std::uint32_t kFirstFaces = 512;

// Synthetic homes below the current folder. Those of `enfilade demo` if they are there, else two
// that are made now, with pictures of at most kFirstFaces texels and instructions. Files of a
// killed run are kept.
fs::path make_first_homes(std::uint32_t faces) {
  fs::path of_demo = "enfilade-demo/homes", own = "enfilade-demo/two-homes";
  if (is_complete(of_demo)) return of_demo;
  if (is_complete(own)) return own;
  say("No data set is named, and ENFILADE_DATA is not set. So two model homes, which are "
      "SYNTHETIC,\n"
      "are made in {}, once. If it is stopped, the next start goes on.\n",
      fs::absolute(own).string());
  std::fflush(stdout);
  homes::HomeSetOptions two = homes::home_set_preset("pretty");
  two.homes = 2;
  two.stairs_every = 0;
  two.least_area = two.most_area = 60;  // square metres
  two.face_size = fs::exists(own / "homes.json") ? homes::read_home_options(own).face_size
                                                 : std::min(faces, kFirstFaces);
  homes::write_homes(own, two, told_homes(two.homes));
  homes::HomePathOptions paths;
  paths.test_split = false;
  homes::write_home_paths(own, paths, set_bar("instructions"));
  return own;
}

// Makes the pictures of these homes again with larger faces, while they are looked at. In a process
// of its own: it yields to this one, its memory is given back, and it ends with this one at any
// moment (docs/design/larger-pictures.md). \param count of homes to work on  \param changing
// becomes false when it is done
void enlarge_beside(const fs::path& homes, std::size_t count, std::uint32_t faces,
                    const std::shared_ptr<std::atomic<bool>>& changing) {
  const homes::HomeSetOptions made = homes::read_home_options(homes);
  say("Larger pictures of {} are being made beside, in some minutes; --faces {} leaves that out.\n",
      counted(count, "home"), made.pretty > 0 ? homes::kPrettyFaceSize : made.face_size);
  std::thread([homes = homes.string(), faces, changing] {
    const int status = run_command({"sh", "-c", "exec nice -n 10 \"$0\" \"$@\" >/dev/null 2>&1",
                                    own_program().string(), "homes", "--output", homes, "--enlarge",
                                    std::to_string(faces)});
    changing->store(false);
    if (status == kSuccess) {
      say("The larger pictures are there: load a page again to see them.\n");
    } else if (status != kInternal) {  // that is also what Ctrl-C gives it
      say(stderr,
          "warning: larger pictures were not made; `enfilade homes -o {} --enlarge {}` "
          "tells why\n",
          homes, faces);
    }
    std::fflush(stdout);
  }).detach();
}

// Submits, for each phase, results of two agents that learn nothing: the shortest path, an oracle,
// and Room-to-Room's random agent. It sends them over HTTP, as teams do, so that the leaderboard is
// a real one. Returns when they are scored. A repeated call changes nothing. \param data  of `site`
void submit_first_agents(const fs::path& data, const service::Site& site,
                         const std::string& database, const std::string& server) {
  const dataset::Dataset dataset(data);
  for (const FirstAgent& first : kAgents) {
    const auto agent = agents::make_agent(first.name);
    service::Client client(server, token_of(database, first.team));
    for (const service::Phase& phase : site.phases()) {
      const tasks::EpisodeSet episodes = dataset.episodes(phase.split);
      const std::string results = to_json(agents::run_agent(*agent, episodes), episodes);
      wait_until_scored(client, client.submit(phase.name, first.method, results).id);
    }
    service::revoke_tokens(database, service::TokenRole::kTeam, first.team);
  }
}

/// A user who names neither a data set nor rules for one gets something to look at.
bool is_first_visit(const Options& options) {
  return options.data.empty() && options.phases.empty() &&
         !dataset::Dataset::from_environment().has_value();
}

sem_t asked_to_end;

// By handlers, as any thread may get the signal: those that made the homes are still there, and
// block none.
void listen_for_the_end() {
  sem_init(&asked_to_end, 0, 0);
  struct sigaction action {};
  action.sa_handler = [](int /*signal*/) { sem_post(&asked_to_end); };
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

// The agents are there to be looked at: the server is as good without them.
void show_first_agents(const fs::path& data, const service::Site& site, const Options& options,
                       int port) {
  const std::string& host = options.config.host;
  try {
    submit_first_agents(data, site, options.config.database,
                        fmt::format("http://{}:{}", host == "0.0.0.0" ? "127.0.0.1" : host, port));
  } catch (const Error& error) {
    say(stderr, "The leaderboard stays without the two agents: {}\n", error.what());
  }
}

// Without its name, a server behind a proxy would refuse all its visitors, one by one.
void check_names(const service::ServerConfig& config) {
  if (config.behind_proxy && config.public_names.empty()) {
    throw UsageError(
        "--behind-proxy: needs the name by which visitors reach the proxy: --public-name "
        "vln.example.org");
  }
}

// Before anything is made for a server that then does not start.
void check_runs(const fs::path& runs) {
  if (runs.empty() || fs::is_directory(runs)) return;
  throw FileError(fmt::format("{}: not a folder; --runs names one that holds runs, or a run's own",
                              runs.string()));
}

ExitCode serve(Options options) {
  check_names(options.config);
  check_runs(options.config.runs);
  share_heaps();  // before there are threads
  const bool first_visit = is_first_visit(options);
  if (first_visit) {
    check_port_is_free(options.config);
    if (options.organiser.empty()) options.organiser = "you";
    if (options.log.empty()) options.log = "none";  // what it prints is to be read
  }
  const fs::path data =
      first_visit ? make_first_homes(options.faces) : open_data(options.data).folder();
  listen_for_the_end();  // until now a signal ends the process at once
  service::ServerConfig& config = options.config;
  config.database = database_of(options.database, data / "enfilade-service.sqlite");
  config.log = log_of(options.log);
  const auto site =
      service::Site::open(data, options.phases.empty() ? std::vector<service::Phase>{}
                                                       : service::load_phases(options.phases));
  const auto warn = [](std::string_view text) { say(stderr, "warning: {}\n", text); };
  for (const std::string& notice : site->notices()) warn(notice);
  config.warn = warn;
  // True before the first request: a browser would keep a small picture for a day.
  const std::size_t to_enlarge =
      first_visit ? homes::scans_to_enlarge(data, options.faces).size() : 0;
  const auto changing = std::make_shared<std::atomic<bool>>(to_enlarge > 0);
  config.pictures_change = [changing] { return changing->load(); };
  service::give_back_large_memory();
  service::Server server(site, config);
  if (first_visit) show_first_agents(data, *site, options, server.port());
  const std::string address = fmt::format("http://{}:{}/", config.host, server.port());
  say("{} scans{} at {}{}\n", site->graphs().size(),
      site->synthetic() ? " (model homes: synthetic)" : "", address,
      service::has_web_client() ? "" : "api/v1/ (this build has no web client)");
  if (to_enlarge > 0) enlarge_beside(data, to_enlarge, options.faces, changing);
  if (!options.organiser.empty()) print_first_steps(options, address);
  std::fflush(stdout);
  while (sem_wait(&asked_to_end) != 0) {  // until the process is asked to end
  }
  server.stop();
  return kSuccess;
}

const std::map<std::string, service::TokenRole> kTokenRoles{
    {"organiser", service::TokenRole::kOrganiser},
    {"reviewer", service::TokenRole::kReviewer},
    {"team", service::TokenRole::kTeam}};

void add_database_option(CLI::App& verb, std::string& database) {
  add_value(verb, "--db", database, "FILE|URL",
            "The server's database (default: ENFILADE_DATABASE)");
}

struct Token {
  std::string database, label;
  std::string role = "organiser";
  std::optional<int> days;
};

void add_token_options(CLI::App& verb, Token& token) {
  add_database_option(verb, token.database);
  verb.add_option("--label", token.label, "Owner of the token; a team's name")->required();
  add_setting(verb, "--role", token.role, "",
              "organiser: everything; reviewer: what workers submitted; team: its submissions",
              CLI::IsMember(kTokenRoles));
}

void add_token(CLI::App& serve_verb, int& status) {
  CLI::App& verb = *serve_verb.add_subcommand(
      "token", "Make an organiser's, a reviewer's or a team's token; prints it once");
  const auto token = std::make_shared<Token>();
  add_token_options(verb, *token);
  verb.add_option("--days", token->days, "Until it expires (default: never)")
      ->check(CLI::Range(1, 3650));
  set_examples(verb, {"enfilade serve token --db vln.sqlite --label Ada --days 90",
                      "enfilade serve token --db vln.sqlite --label Ben --role reviewer",
                      "enfilade serve token --db vln.sqlite --label 'A team' --role team"});
  verb.callback([token, &status] {
    say("{}\n", service::create_token(database_of(token->database), kTokenRoles.at(token->role),
                                      token->label, token->days));
    status = kSuccess;
  });
}

void add_revoke(CLI::App& serve_verb, int& status) {
  CLI::App& verb = *serve_verb.add_subcommand(
      "revoke", "Revoke tokens at once, also while a server uses the database");
  const auto token = std::make_shared<Token>();
  add_token_options(verb, *token);
  set_examples(verb, {"enfilade serve revoke --db vln.sqlite --label Ada",
                      "enfilade serve revoke --db vln.sqlite --label 'A team' --role team"});
  verb.callback([token, &status] {
    const int revoked = service::revoke_tokens(database_of(token->database),
                                               kTokenRoles.at(token->role), token->label);
    if (revoked == 0) {
      throw LookupError(
          fmt::format("--label: {:?}, and no {}'s token has it", token->label, token->role));
    }
    say("{} revoked\n", revoked);
    status = kSuccess;
  });
}

void add_approve(CLI::App& serve_verb, int& status) {
  struct Approve {
    std::string database, team;
    bool is_new = false, withdraw = false;
  };
  CLI::App& verb = *serve_verb.add_subcommand(
      "approve", "Let a team submit to phases with secret goals, also while serving");
  const auto approve = std::make_shared<Approve>();
  add_database_option(verb, approve->database);
  add_value(verb, "--team", approve->team, "NAME", "Name of the team")->required();
  auto* is_new =
      verb.add_flag("--new", approve->is_new, "Make the team first; prints its token, once");
  verb.add_flag("--withdraw", approve->withdraw,
                "Withdraw the approval; the team's submissions stay, but are hidden")
      ->excludes(is_new);
  set_examples(verb, {"enfilade serve approve --db vln.sqlite --team 'A team'",
                      "enfilade serve approve --db vln.sqlite --team 'Another team' --new",
                      "enfilade serve approve --db vln.sqlite --team 'A team' --withdraw"});
  verb.callback([approve, &status] {
    if (approve->is_new) {
      say("{}\n", service::create_team(database_of(approve->database), approve->team));
    } else {
      service::set_approval(
          database_of(approve->database), approve->team,
          approve->withdraw ? service::Approval::kWithdrawn : service::Approval::kGiven);
      say("{}\n", approve->withdraw ? "approval withdrawn" : "approved");
    }
    status = kSuccess;
  });
}

void add_backup(CLI::App& serve_verb, int& status) {
  struct Backup {
    std::string database, copy;
  };
  CLI::App& verb =
      *serve_verb.add_subcommand("backup", "Copy the database, also while a server uses it");
  const auto backup = std::make_shared<Backup>();
  add_database_option(verb, backup->database);
  add_value(verb, "copy", backup->copy, "FILE", "File of the copy; written whole, then renamed")
      ->required();
  set_examples(verb, {"enfilade serve backup --db vln.sqlite vln-monday.sqlite"});
  verb.callback([backup, &status] {
    service::back_up_database(database_of(backup->database), backup->copy);
    status = kSuccess;
  });
}

void add_copy(CLI::App& serve_verb, int& status) {
  struct Copy {
    std::string database, file;
  };
  CLI::App& verb = *serve_verb.add_subcommand(
      "copy", "Copy a database file to PostgreSQL, while no server uses either");
  const auto copy = std::make_shared<Copy>();
  add_value(verb, "file", copy->file, "FILE", "Database file of `serve`; it stays")->required();
  add_value(verb, "--db", copy->database, "URL",
            "A database that no server has used (default: ENFILADE_DATABASE)");
  set_examples(verb, {"enfilade serve copy vln.sqlite --db postgresql://enfilade@db/vln"});
  verb.callback([copy, &status] {
    const std::int64_t rows = service::copy_to_postgres(copy->file, database_of(copy->database),
                                                        progress_bar("rows copied"));
    say("{} rows copied\n", rows);
    status = kSuccess;
  });
}

}  // namespace

void add(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand(
      "serve", "Serve a data set, a leaderboard and annotation pages over HTTP");
  const auto options = std::make_shared<Options>();
  add_value(verb, "data", options->data, "DIR",
            "The data set (default: ENFILADE_DATA; without it two model homes, made now)");
  add_value(verb, "--db", options->database, "FILE|URL",
            "Database: a file, made if missing, or postgresql://USER@HOST/NAME (default: "
            "ENFILADE_DATABASE, or enfilade-service.sqlite in the data set)");
  add_value(verb, "--phases", options->phases, "FILE.json",
            "Phases of submissions, with secret goals or without: docs/service_evaluation.md "
            "(default: each split but train that has its goals)");
  add_value(verb, "--runs", options->config.runs, "DIR",
            "Run of `enfilade ask` or `mcp`, or their folder, to show everyone");
  add_setting(verb, "--host", options->config.host, "", "Interface to listen on");
  add_setting(verb, "--port", options->config.port, "", "Port; 0: any free one",
              CLI::Range(0, 65535));
  add_setting(verb, "--threads", options->config.threads, "", "Requests answered at the same time",
              CLI::Range(1, 4096));
  add_value(verb, "--public-name", options->config.public_names, "NAME",
            "Host name of the server; other hosts are refused; may be repeated")
      ->allow_extra_args(false);
  verb.add_flag("--behind-proxy", options->config.behind_proxy,
                "Trust X-Forwarded-For and X-Forwarded-Proto; needs --public-name");
  add_value(verb, "--organiser", options->organiser, "NAME",
            "Print an organiser's token for NAME at start, valid for a day");
  verb.add_flag("--open-registration", options->config.open_registration,
                "Anyone can make a team; secret goals still need an approval");
  verb.add_flag("--accept-leak", options->config.accept_leak,
                "Serve phases whose limits give all their goals away");
  add_setting(verb, "--faces", options->faces, "N",
              "Texels of a first visit's faces; above 512 made while serving",
              whole_number(1, 4096));
  verb.add_option(
          "--log", options->log,
          "One line per request on stderr: text, json or none (default: text; none if DIR and "
          "ENFILADE_DATA are missing)")
      ->check(CLI::IsMember({"text", "json", "none"}));
  add_token(verb, status);
  add_revoke(verb, status);
  add_approve(verb, status);
  add_backup(verb, status);
  add_copy(verb, status);
  verb.require_subcommand(0, 1);
  set_examples(verb, {"enfilade serve", "enfilade homes -o homes && enfilade serve homes",
                      "enfilade serve homes --db vln.sqlite --phases phases.json --port 9000",
                      "enfilade serve token --db vln.sqlite --label Ada",
                      "enfilade serve revoke --db vln.sqlite --label Ada",
                      "enfilade serve approve --db vln.sqlite --team 'A team'",
                      "enfilade serve backup --db vln.sqlite vln-monday.sqlite",
                      "enfilade serve copy vln.sqlite --db postgresql://enfilade@db/vln"});
  verb.callback([&verb, options, &status] {
    if (verb.get_subcommands().empty()) status = serve(*options);
  });
}

}  // namespace enfilade::apps::serve_verb
