/// \file  A scripted worker of a collection, over a real socket.
#pragma once
#include <httplib.h>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

namespace enfilade::service::testing {

/// The body of a collection of the data of served_data.h: one path, three workers, and a seed by
/// which the first worker begins with the first instruction, unless changed.
inline nlohmann::json collection_body(const std::string& name, const std::string& kind) {
  return {{"name", name},
          {"title", "A title"},
          {"kind", kind},
          {"consent", "# Consent\n\nYou *may* stop at any time."},
          {"instructions", "Write so that a smart robot finds the goal."},
          {"sources", nlohmann::json::array({{{"split", "val_seen"}, {"most", 1}}})},
          {"seed", 7}};
}

/// The key in a collection's link.
inline std::string key_of(const nlohmann::json& collection) {
  const auto link = collection.at("link").get<std::string>();
  const std::size_t begin = link.find("&key=") + 5;
  return link.substr(begin, link.find('&', begin) - begin);
}

/// What an answer says, and its "status"; 0 if there was no answer.
inline nlohmann::json read_answer(const httplib::Result& result) {
  if (!result) return {{"status", 0}};
  auto body = nlohmann::json::parse(result->body, nullptr, false);
  if (!body.is_object()) body = nlohmann::json::object();
  body["status"] = result->status;
  return body;
}

/// A task's number, as it is or as an answer has it.
struct TaskId {
  TaskId(std::int64_t task) : value(task) {}                               // NOLINT: either is one
  TaskId(const nlohmann::json& task) : value(task.get<std::int64_t>()) {}  // NOLINT
  std::int64_t value;
};

class Worker {
 public:
  /// Nothing is sent yet. \param parameters of the page's address, the key among them
  Worker(int port, std::string collection, nlohmann::json parameters)
      : collection_(std::move(collection)), parameters_(std::move(parameters)) {
    go_on_at(port);
  }
  /// Further requests go to another server.
  void go_on_at(int port) {
    client_.emplace("127.0.0.1", port);
    client_->set_keep_alive(true);
    client_->set_tcp_nodelay(true);  // else a body waits 40 ms for the acknowledgement of its head
    client_->set_read_timeout(60);   // a machine that has other work to do
    client_->set_default_headers(by_proxy_);
  }
  /// Further requests say that a proxy brings them from that address.
  void come_by_proxy_from(const std::string& address) {
    by_proxy_ = {{"X-Forwarded-For", address}};
    client_->set_default_headers(by_proxy_);
  }

  /// Comes in.
  nlohmann::json join() {
    const std::string body = nlohmann::json{{"parameters", parameters_}}.dump();
    auto answer = answered(
        [&] { return client_->Post("/api/v1/collections/" + collection_ + "/join", body, kJson); });
    if (answer.contains("token")) {
      token_ = {{"Authorization", "Bearer " + answer["token"].get<std::string>()}};
    }
    return answer;
  }
  nlohmann::json consent() { return put("/api/v1/visit/consent", nlohmann::json::object()); }
  nlohmann::json lease() {
    return answered([&] { return client_->Post("/api/v1/visit/task", token_, "{}", kJson); });
  }
  nlohmann::json visit() {
    return answered([&] { return client_->Get("/api/v1/visit", token_); });
  }
  /// Joins, agrees and leases. \returns the task; null if there is none
  nlohmann::json begin() {
    join();
    consent();
    return lease().value("task", nlohmann::json());
  }

  nlohmann::json write(const TaskId& task, const std::string& instruction) {
    return put(address(task) + "/submission", {{"instruction", instruction}, {"seconds", 42.5}});
  }
  nlohmann::json walk(const TaskId& task, const nlohmann::json& steps) {
    return put(address(task) + "/submission",
               {{"steps", steps}, {"camera", {{"width", 640}, {"height", 480}, {"vfov", 1.047}}}});
  }
  nlohmann::json draft(const TaskId& task, const nlohmann::json& draft) {
    return put(address(task) + "/draft", {{"draft", draft}});
  }
  nlohmann::json give_back(const TaskId& task) {
    return answered([&] { return client_->Delete(address(task), token_); });
  }
  nlohmann::json task(const TaskId& task) {
    return answered([&] { return client_->Get(address(task), token_); });
  }

  nlohmann::json put(const std::string& target, const nlohmann::json& body) {
    return answered([&] { return client_->Put(target, token_, body.dump(), kJson); });
  }
  const httplib::Headers& headers() const { return token_; }
  std::size_t sent_again() const { return sent_again_; }  ///< requests that had no answer at first

 private:
  static constexpr const char* kJson = "application/json";

  /// Once more on a new connection if the one that was kept open is closed just now, as browsers
  /// do.
  template <class Call>
  nlohmann::json answered(const Call& call) {
    httplib::Result result = call();
    if (result) return read_answer(result);
    ++sent_again_;
    return read_answer(call());
  }
  static std::string address(const TaskId& task) {
    return "/api/v1/tasks/" + std::to_string(task.value);
  }

  std::optional<httplib::Client> client_;  // always there
  std::string collection_;
  nlohmann::json parameters_;
  httplib::Headers token_, by_proxy_;
  std::size_t sent_again_ = 0;
};

/// Steps along v<first> ... v<last> of the row, a second each.
inline nlohmann::json row_steps(int first, int last) {
  auto steps = nlohmann::json::array();
  const int way = first <= last ? 1 : -1;
  for (int v = first; v != last + way; v += way) {
    steps.push_back({{"viewpoint", "v" + std::to_string(v)},
                     {"heading", 1.5},
                     {"elevation", 0.0},
                     {"seconds", static_cast<double>(steps.size())}});
  }
  return steps;
}

}  // namespace enfilade::service::testing
