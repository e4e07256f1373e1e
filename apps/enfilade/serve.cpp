// enfilade serve: a data set, its viewer and its evaluation over HTTP.
#include "enfilade/service/server.h"

#include <fmt/format.h>
#include <malloc.h>
#include <csignal>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/common/program.h"
#include "apps/enfilade/verbs.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string data;
  std::string database;
  std::string phases;
  std::string log = "text";
  service::ServerConfig config;
};

void print_json(const service::RequestRecord& record) {
  nlohmann::ordered_json line{{"address", record.address}, {"method", record.method},
                              {"path", record.path},       {"status", record.status},
                              {"bytes", record.bytes},     {"seconds", record.seconds}};
  if (!record.who.empty()) line["who"] = record.who;
  if (!record.fault.empty()) line["fault"] = record.fault;
  fmt::print(stderr, "{}\n",
             line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

void print_text(const service::RequestRecord& record) {
  fmt::print(stderr, "{} {} {:?} {} {} B {:.1f} ms{}{}\n", record.address, record.method,
             record.path, record.status, record.bytes, record.seconds * 1000,
             record.fault.empty() ? "" : " fault: ", record.fault);
}

std::function<void(const service::RequestRecord&)> log_of(const std::string& kind) {
  if (kind == "none") return {};
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

ExitCode serve(Options options) {
  share_heaps();  // before there are threads
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);  // before there are threads, who inherit it
  const fs::path data = open_data(options.data).folder();
  service::ServerConfig& config = options.config;
  config.database =
      options.database.empty() ? data / "enfilade-service.sqlite" : fs::path(options.database);
  config.log = log_of(options.log);
  const auto site =
      service::Site::open(data, options.phases.empty() ? std::vector<service::Phase>{}
                                                       : service::load_phases(options.phases));
  service::Server server(site, config);
  fmt::print("{} scans{} at http://{}:{}/{}\n", site->graphs().size(),
             site->synthetic() ? " (model homes: synthetic)" : "", config.host, server.port(),
             service::has_web_client() ? "" : "api/v1/ (this build has no web client)");
  std::fflush(stdout);
  int received = 0;
  sigwait(&signals, &received);  // until the process is asked to end
  server.stop();
  return kSuccess;
}

void add_serve_options(CLI::App& verb, Options& options) {
  verb.add_option("data", options.data, "The data set (default: ENFILADE_DATA)")->type_name("DIR");
  verb.add_option("--db", options.database,
                  "The database, made if it isn't there (default: enfilade-service.sqlite in the "
                  "data set)")
      ->type_name("FILE");
  verb.add_option("--phases", options.phases,
                  "What submissions are scored on, with secret goals or without: docs/service.md "
                  "(default: each split but train that has its goals)")
      ->type_name("FILE.json");
  verb.add_option("--host", options.config.host, "Interface to listen on")->capture_default_str();
  verb.add_option("--port", options.config.port, "0: any that is free")
      ->capture_default_str()
      ->check(CLI::Range(0, 65535));
  verb.add_option("--threads", options.config.threads,
                  "Connections that are served at the same time")
      ->capture_default_str()
      ->check(CLI::Range(1, 4096));
  verb.add_flag("--behind-proxy", options.config.behind_proxy,
                "Believe X-Forwarded-For and X-Forwarded-Proto");
  verb.add_flag_callback(
      "--closed-registration", [&options] { options.config.open_registration = false; },
      "Nobody can make a team by the page or the API");
  verb.add_option("--log", options.log, "One line a request on stderr: text, json or none")
      ->capture_default_str()
      ->check(CLI::IsMember({"text", "json", "none"}));
}

const std::map<std::string, service::TokenRole> kTokenRoles{
    {"organiser", service::TokenRole::kOrganiser},
    {"reviewer", service::TokenRole::kReviewer},
    {"team", service::TokenRole::kTeam}};

struct Token {
  std::string database, label;
  std::string role = "organiser";
  std::optional<int> days;
};

void add_token_options(CLI::App& verb, Token& token) {
  verb.add_option("--db", token.database, "The server's database")->required()->type_name("FILE");
  verb.add_option("--label", token.label, "Whose it is; of a team, its name")->required();
  verb.add_option("--role", token.role,
                  "organiser: everything; reviewer: what workers handed in; team: its submissions")
      ->capture_default_str()
      ->check(CLI::IsMember(kTokenRoles));
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
    fmt::print("{}\n", service::create_token(token->database, kTokenRoles.at(token->role),
                                             token->label, token->days));
    status = kSuccess;
  });
}

void add_revoke(CLI::App& serve_verb, int& status) {
  CLI::App& verb = *serve_verb.add_subcommand(
      "revoke", "Take somebody's tokens back, at once, also while a server uses the database");
  const auto token = std::make_shared<Token>();
  add_token_options(verb, *token);
  set_examples(verb, {"enfilade serve revoke --db vln.sqlite --label Ada",
                      "enfilade serve revoke --db vln.sqlite --label 'A team' --role team"});
  verb.callback([token, &status] {
    const int revoked =
        service::revoke_tokens(token->database, kTokenRoles.at(token->role), token->label);
    if (revoked == 0) {
      throw LookupError(
          fmt::format("--label: {:?}, and no {}'s token has it", token->label, token->role));
    }
    fmt::print("{} revoked\n", revoked);
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
  verb.add_option("--db", backup->database, "The server's database")->required()->type_name("FILE");
  verb.add_option("copy", backup->copy, "Written whole, then renamed")
      ->required()
      ->type_name("FILE");
  set_examples(verb, {"enfilade serve backup --db vln.sqlite vln-monday.sqlite"});
  verb.callback([backup, &status] {
    service::back_up_database(backup->database, backup->copy);
    status = kSuccess;
  });
}

}  // namespace

void add_serve(CLI::App& app, int& status) {
  CLI::App& verb = *app.add_subcommand(
      "serve",
      "A data set in the browser, a benchmark with a leaderboard, and collecting instructions");
  const auto options = std::make_shared<Options>();
  add_serve_options(verb, *options);
  add_token(verb, status);
  add_revoke(verb, status);
  add_backup(verb, status);
  verb.require_subcommand(0, 1);
  set_examples(verb, {"enfilade homes -o homes && enfilade serve homes",
                      "enfilade serve homes --db vln.sqlite --phases phases.json --port 9000",
                      "enfilade serve token --db vln.sqlite --label Ada",
                      "enfilade serve revoke --db vln.sqlite --label Ada",
                      "enfilade serve backup --db vln.sqlite vln-monday.sqlite"});
  verb.callback([&verb, options, &status] {
    if (verb.get_subcommands().empty()) status = serve(*options);
  });
}

}  // namespace enfilade::apps
