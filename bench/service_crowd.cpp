// 200 scripted workers at servers of their own, for a minute: what each of them waits for, what is
// lost, and what the servers need. \returns 1 if any of them saw an error, or anything is lost
//   service_crowd ENFILADE DATA SPLIT [WORKERS [SECONDS [sqlite|postgres [SERVERS]]]]
// Of several servers on one database, a worker takes a task from one and hands it in to the next.
#include <fmt/format.h>
#include <sys/resource.h>
#include <algorithm>
#include <atomic>
#include <list>
#include <mutex>

#include "enfilade/core/rng.h"
#include "enfilade/service/server.h"
#include "tests/service/program.h"
#include "tests/support/postgres_server.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/worker.h"

namespace enfilade::service {
namespace {

using nlohmann::json;
using testing::Worker;
using Steady = std::chrono::steady_clock;

struct Totals {
  std::mutex mutex;
  std::vector<double> seconds;  // of each request
  std::vector<std::string> instructions;
  std::size_t walks = 0, sent_again = 0;
  std::vector<std::string> errors;
};

struct Crowd {
  std::vector<int> ports;
  std::string write_key, walk_key;
  Steady::time_point end;
  Totals totals;
};

/// One worker: comes, then takes tasks and hands them in, with drafts and pauses, until the end.
class Person {
 public:
  Person(Crowd& crowd, std::size_t number)
      : crowd_(crowd),
        number_(number),
        walks_(number % 2 == 1),
        rng_(number),
        worker_(port(), walks_ ? "walk" : "write",
                {{"key", walks_ ? crowd.walk_key : crowd.write_key},
                 {"worker", "person " + std::to_string(number)}}),
        client_("127.0.0.1", port()) {
    client_.set_read_timeout(60);
    // An address of their own each, as the server takes so many newcomers a minute from one.
    worker_.come_by_proxy_from(fmt::format("10.1.{}.{}", number / 250, number % 250));
  }

  void live() {
    pause(3.0);  // nobody comes at the same moment
    timed([&] { return worker_.join(); });
    timed([&] { return worker_.consent(); });
    while (Steady::now() < crowd_.end) {
      const json task = timed([&] { return worker_.lease(); }).value("task", json());
      if (!task.is_object()) break;
      look(task);
      if (crowd_.ports.size() > 1) {
        ++at_;
        worker_.go_on_at(port());
      }
      walks_ ? walk(task) : write(task);
      ++done_;
    }
    const std::scoped_lock lock(crowd_.totals.mutex);
    Totals& totals = crowd_.totals;
    totals.seconds.insert(totals.seconds.end(), seconds_.begin(), seconds_.end());
    totals.errors.insert(totals.errors.end(), errors_.begin(), errors_.end());
    totals.instructions.insert(totals.instructions.end(), instructions_.begin(),
                               instructions_.end());
    totals.walks += walked_;
    totals.sent_again += worker_.sent_again();
  }

 private:
  template <class Call>
  json timed(const Call& call) {
    const auto begin = Steady::now();
    json answer = call();
    seconds_.push_back(std::chrono::duration<double>(Steady::now() - begin).count());
    if (answer.at("status") != 200) errors_.push_back(answer.dump());
    return answer;
  }

  int port() const { return crowd_.ports[(number_ + at_) % crowd_.ports.size()]; }

  void pause(double most_seconds) {
    std::this_thread::sleep_for(std::chrono::duration<double>(most_seconds * rng_.uniform()));
  }

  /// What a page asks for before it shows a task: the scan, and the faces of a viewpoint.
  void look(const json& task) {
    const std::string scan = "/api/v1/scans/" + task.at("scan").get<std::string>();
    timed([&] { return testing::read_answer(client_.Get(scan)); });  // no connection is kept
    const auto viewpoint =
        (task.contains("path") ? task["path"][0] : task["start"]).get<std::string>();
    for (int face = 0; face < 6; ++face) {
      const auto got =
          client_.Get(fmt::format("{}/viewpoints/{}/faces/{}.jpg", scan, viewpoint, face));
      if (!got || (got->status != 200 && got->status != 404)) errors_.emplace_back("a face");
    }
  }

  void write(const json& task) {
    const std::string text =
        fmt::format("Walk to the door, says person {} the {}th time.", number_, done_);
    for (int k = 0; k < 3; ++k) {
      pause(1.0);
      timed([&] { return worker_.draft(task.at("task"), {{"text", text.substr(0, 10)}}); });
    }
    if (timed([&] { return worker_.write(task.at("task"), text); }).at("status") == 200) {
      instructions_.push_back(text);
    }
  }

  // On the spot: the graph is not looked at here.
  void walk(const json& task) {
    pause(2.0);
    const json step{{"viewpoint", task.at("start")},
                    {"heading", task.at("heading")},
                    {"elevation", 0},
                    {"seconds", static_cast<double>(done_)}};
    json steps = json::array();
    for (int k = 0; k < 30; ++k) steps.push_back(step);
    const json done = timed([&] { return worker_.walk(task.at("task"), steps); });
    if (done.at("status") == 200) ++walked_;
  }

  Crowd& crowd_;
  std::size_t number_, at_ = 0;
  bool walks_;
  Rng rng_;
  Worker worker_;
  httplib::Client client_;
  std::size_t done_ = 0, walked_ = 0;
  std::vector<double> seconds_;
  std::vector<std::string> instructions_, errors_;
};

std::string make_collection(int port, const httplib::Headers& organiser, const std::string& kind,
                            const std::string& split, std::size_t per_item) {
  json body = testing::collection_body(kind, kind);
  body["sources"] = json::array({{{"split", split}}});
  body["per_item"] = per_item;
  httplib::Client client("127.0.0.1", port);
  client.set_read_timeout(60);
  return testing::key_of(testing::read_answer(
      client.Post("/api/v1/collections", organiser, body.dump(), "application/json")));
}

double resident_megabytes(int port) {
  const auto metrics = httplib::Client("127.0.0.1", port).Get("/metrics");
  const std::string name = "\nprocess_resident_memory_bytes ";
  const std::size_t at = metrics ? metrics->body.find(name) : std::string::npos;
  return at == std::string::npos ? 0 : std::atof(&metrics->body[at + name.size()]) / 1e6;
}

/// Instructions that are not in the export exactly once.
std::size_t count_lost(int port, const httplib::Headers& organiser, const std::string& split,
                       const std::vector<std::string>& written) {
  httplib::Client client("127.0.0.1", port);
  client.set_read_timeout(60);
  const auto file =
      client.Get("/api/v1/collections/write/export?state=all&split=" + split, organiser);
  std::vector<std::string> found;
  for (const json& path : json::parse(file->body)) {
    for (const json& text : path.at("instructions")) found.push_back(text.get<std::string>());
  }
  std::ranges::sort(found);
  return static_cast<std::size_t>(std::ranges::count_if(written, [&](const std::string& text) {
    return std::ranges::equal_range(found, text).size() != 1;
  }));
}

/// Walks in the database, whoever knows of them.
std::size_t count_walks(int port, const httplib::Headers& organiser) {
  httplib::Client client("127.0.0.1", port);
  const json collection = testing::read_answer(client.Get("/api/v1/collections/walk", organiser));
  return collection.at("progress").at("submitted").get<std::size_t>();
}

/// A file in a folder, or a database on a server of PostgreSQL that ends with this object.
class Place {
 public:
  explicit Place(const std::string& kind) {
    if (kind == "postgres") server_.emplace();
  }
  std::string make() {
    return server_ ? server_->make_database() : (folder_.path() / "crowd.sqlite").string();
  }

 private:
  tests::TemporaryFolder folder_{"crowd"};
  std::optional<tests::PostgresServer> server_;
};

// As many as this process may have: each worker has two connections.
void allow_many_connections() {
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = files.rlim_max;
  setrlimit(RLIMIT_NOFILE, &files);
}

int run(const std::vector<std::string>& words) {
  if (words.size() < 3) {
    fmt::print(stderr,
               "usage: service_crowd ENFILADE DATA SPLIT [WORKERS [SECONDS [sqlite|postgres "
               "[SERVERS]]]]\n");
    return 2;
  }
  const std::string& split = words[2];
  const std::size_t workers = words.size() > 3 ? std::stoul(words[3]) : 200;
  const int seconds = words.size() > 4 ? std::stoi(words[4]) : 60;
  const std::string kind = words.size() > 5 ? words[5] : "sqlite";
  const std::size_t servers = words.size() > 6 ? std::stoul(words[6]) : 1;
  allow_many_connections();
  Place place(kind);
  const std::string database = place.make();
  Crowd crowd;
  std::list<testing::Program> programs;
  for (std::size_t k = 0; k < servers; ++k) {
    programs.emplace_back(
        words[0], words[1], database,
        std::vector<std::string>{"--threads", std::to_string(256 + workers), "--behind-proxy",
                                 "--public-name", "crowd.example.org"});
    programs.back().start();
    crowd.ports.push_back(programs.back().port());
  }
  const int port = crowd.ports.front();
  const httplib::Headers organiser{
      {"Authorization",
       "Bearer " + create_token(database, TokenRole::kOrganiser, "o", std::nullopt)}};
  // Of 200 workers three do one task, of 1,000 fifteen: there is work for all the time.
  const std::size_t per_item = std::max<std::size_t>(3, workers * 3 / 200);
  crowd.write_key = make_collection(port, organiser, "write", split, per_item);
  crowd.walk_key = make_collection(port, organiser, "walk", split, per_item);
  crowd.end = Steady::now() + std::chrono::seconds(seconds);
  std::vector<std::thread> people;
  for (std::size_t k = 0; k < workers; ++k) {
    people.emplace_back([&crowd, k] { Person(crowd, k).live(); });
  }
  double most_memory = 0;  // of one server
  while (Steady::now() < crowd.end) {
    for (const int one : crowd.ports) most_memory = std::max(most_memory, resident_megabytes(one));
    std::this_thread::sleep_for(std::chrono::seconds(1));
  }
  for (std::thread& person : people) person.join();
  Totals& totals = crowd.totals;
  std::ranges::sort(totals.seconds);
  const auto at = [&](double share) {
    const auto k = static_cast<std::size_t>(share * static_cast<double>(totals.seconds.size() - 1));
    return totals.seconds[k] * 1000;
  };
  const std::size_t lost = count_lost(port, organiser, split, totals.instructions);
  const std::size_t walks = count_walks(port, organiser);
  fmt::print(
      "{} workers, {} s, {} server(s) on {}: {} requests beside faces, median {:.1f} ms, p99 "
      "{:.1f} ms, longest {:.1f} ms\n{} instructions acknowledged, {} lost or double; {} walks "
      "acknowledged, {} in the database; {} requests sent again for want of an answer; {} errors; "
      "{:.0f} MB resident at most\n",
      workers, seconds, servers, kind, totals.seconds.size(), at(0.5), at(0.99), at(1.0),
      totals.instructions.size(), lost, totals.walks, walks, totals.sent_again,
      totals.errors.size(), most_memory);
  for (std::size_t k = 0; k < std::min<std::size_t>(5, totals.errors.size()); ++k) {
    fmt::print("error: {}\n", totals.errors[k].substr(0, 200));
  }
  return totals.errors.empty() && lost == 0 && walks >= totals.walks ? 0 : 1;
}

}  // namespace
}  // namespace enfilade::service

int main(int count, char** words) { return enfilade::service::run({words + 1, words + count}); }
