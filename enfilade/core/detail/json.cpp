#include "enfilade/core/detail/json.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "enfilade/core/gzip.h"
#include "enfilade/core/nearest_name.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/utf8.h"

namespace enfilade::json {
namespace {

constexpr std::size_t kDeepest = simdjson::DEFAULT_MAX_DEPTH;

// Keys are foreign texts: a long one would stand in each fault below it.
std::string key_text(std::string_view key) {
  constexpr std::size_t kMost = kLongestInstructionId;
  const bool plain = !key.empty() && key.size() <= kMost && std::ranges::all_of(key, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
  return plain ? fmt::format(".{}", key) : fmt::format("[{}]", quote(key, kMost));
}

// Second reading of a document that simdjson refused. simdjson says what is wrong but not where;
// this slow reader follows the path and stops at the first fault.
class FaultFinder : public nlohmann::json_sax<nlohmann::json> {
 public:
  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const string_t&) override { return value(); }
  bool string(string_t&) override { return value(); }
  bool binary(binary_t&) override { return value(); }
  bool start_object(std::size_t) override { return open(false); }
  bool start_array(std::size_t) override { return open(true); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    levels_.back().key = name;
    return true;
  }
  bool parse_error(std::size_t at, const std::string&, const nlohmann::json::exception&) override {
    position = at;
    return false;
  }

  std::string path() const {
    std::string text = "$";
    for (const Level& level : levels_) {
      text += level.is_array ? fmt::format("[{}]", level.index) : key_text(level.key);
      if (text.size() > 200) return text + "...";  // hostile nesting is not worth printing
    }
    return text;
  }

  std::size_t position = 0;
  bool too_deep = false;  // stopped for that: a level takes 40 times the byte that opens it

 private:
  struct Level {
    bool is_array = false;
    std::size_t index = 0;
    std::string key;
  };

  bool value() {
    if (!levels_.empty() && levels_.back().is_array) ++levels_.back().index;
    return true;
  }
  bool open(bool is_array) {
    too_deep = levels_.size() == kDeepest;
    if (too_deep) return false;
    levels_.push_back({is_array, 0, ""});
    return true;
  }
  bool close() {
    levels_.pop_back();
    return value();
  }

  std::vector<Level> levels_;
};

std::string place(std::string_view text, std::size_t position) {
  const std::string_view before = text.substr(0, std::min(position, text.size()));
  const auto line = std::ranges::count(before, '\n') + 1;
  const std::size_t start = before.rfind('\n') + 1;  // npos + 1 is 0: the first line
  return fmt::format("line {}, column {}", line, std::max<std::size_t>(before.size() - start, 1));
}

// The syntax error of a text; nothing if nlohmann's reader finds none.
std::optional<Diagnostic> find_fault(std::string_view text, const std::string& name) {
  Diagnostic fault{Severity::kError, name, "$", "not-json", ""};
  FaultFinder finder;
  if (nlohmann::json::sax_parse(text.begin(), text.end(), &finder)) return std::nullopt;
  if (finder.too_deep) {
    fault.message = simdjson::error_message(simdjson::DEPTH_ERROR);
    return fault;
  }
  fault.where = finder.path();
  const std::size_t at = finder.position > 0 ? finder.position - 1 : 0;
  const std::string_view rest = text.substr(std::min(at, text.size()));
  fault.message = place(text, finder.position) + ": ";
  if (rest.empty()) {
    fault.message += text.empty() ? "the file is empty, not JSON" : "the file ends too early";
  } else if (rest[0] == 'N' || rest[0] == 'I' || rest.starts_with("-I")) {
    fault.message += "NaN and Infinity are not JSON; finite numbers are allowed";
  } else {
    fault.message += fmt::format("not JSON at {:?}", rest.substr(0, 12));
  }
  return fault;
}

template <class T>
std::optional<T> read(Element element, const Path& path, Faults& faults, const char* code,
                      const char* allowed) {
  T value{};
  if (element.get(value) == simdjson::SUCCESS) return value;
  faults.error(path, code, fmt::format("{}, not {}", describe(element), allowed));
  return std::nullopt;
}

// What `read` gives for each element of an array; "" where it reports a fault.
template <class Read>
std::vector<std::string> list_of(Element element, const Path& path, Faults& faults,
                                 const Read& read) {
  std::vector<std::string> texts;
  const auto elements = array(element, path, faults);
  if (!elements) return texts;
  for (const Element one : *elements) {
    if (faults.full()) break;
    texts.emplace_back(read(one, Path(path, texts.size()), faults).value_or(""));
  }
  return texts;
}

}  // namespace

std::string Path::text() const {
  if (parent_ == nullptr) return "$";
  return parent_->text() + (key_.data() == nullptr ? fmt::format("[{}]", index_) : key_text(key_));
}

void Faults::add(Severity severity, const Path& path, std::string code, std::string message) {
  std::size_t& found = severity == Severity::kError ? errors_ : others_;
  if (++found > kMostFaultsKept) return;  // before path.text(), which takes most of the time
  diagnostics_.push_back({severity, file_, path.text(), std::move(code), std::move(message)});
}

void Faults::add(Diagnostic found) {
  std::size_t& same = found.severity == Severity::kError ? errors_ : others_;
  if (++same <= kMostFaultsKept) diagnostics_.push_back(std::move(found));
}

void Faults::append(Faults part) {
  const std::size_t errors = errors_ + part.errors_, others = others_ + part.others_;
  for (Diagnostic& one : part.diagnostics_) add(std::move(one));
  errors_ = errors;
  others_ = others;
  if (!stopped()) stopped_at_ = std::move(part.stopped_at_);
}

void Faults::stop(const Path& path) {
  if (!stopped()) stopped_at_ = path.text();
}

std::vector<Diagnostic> Faults::take() {
  const auto tell = [this](Severity severity, std::string where, std::string message) {
    diagnostics_.push_back(
        {severity, file_, std::move(where), std::string(kMoreFaults), std::move(message)});
  };
  if (stopped()) {
    tell(Severity::kError, stopped_at_,
         fmt::format("not read from here on, after {} errors; there may be more", errors_));
  } else if (errors_ > kMostFaultsKept) {
    tell(Severity::kError, "$",
         fmt::format("{} more errors; the first {} are listed", errors_ - kMostFaultsKept,
                     kMostFaultsKept));
  }
  if (others_ > kMostFaultsKept) {
    tell(Severity::kWarning, "$",
         fmt::format("{} more warnings and notes; the first {} are listed",
                     others_ - kMostFaultsKept, kMostFaultsKept));
  }
  errors_ = others_ = 0;
  stopped_at_.clear();
  return std::exchange(diagnostics_, {});
}

void Faults::throw_if_errors() {
  if (errors_ > 0) throw InvalidInput(take());
}

Document::Document(std::string_view text, std::string name)
    : name_(std::move(name)), parser_(std::make_unique<simdjson::dom::parser>()) {
  text = without_byte_order_mark(text);
  if (text.empty()) text = "";  // an empty view may be null, which memcpy does not allow
  // simdjson copies the text into a buffer with padding.
  const simdjson::error_code code = parser_->parse(text.data(), text.size()).get(root_);
  if (code == simdjson::MEMALLOC) throw std::bad_alloc();
  if (code != simdjson::SUCCESS) throw not_json(text, name_, code);
}

Document Document::load(const std::filesystem::path& path) {
  const std::filesystem::path found = find_text_file(path);
  return {read_text_file(found), found.string()};
}

Document Document::parse(std::string_view text, const std::string& name) { return {text, name}; }

std::size_t skip_string(std::string_view text, std::size_t at) {
  for (;;) {
    const std::size_t quote = text.find('"', at);
    if (quote == std::string_view::npos) return text.size();
    std::size_t slashes = 0;  // the string's own first mark ends them
    while (text[quote - 1 - slashes] == '\\') ++slashes;
    if (slashes % 2 == 0) return quote + 1;
    at = quote + 1;
  }
}

void check_syntax(std::string_view text, const std::string& name) {
  if (auto fault = find_fault(without_byte_order_mark(text), name)) {
    throw InvalidInput({std::move(*fault)});
  }
}

InvalidInput not_json(std::string_view text, const std::string& name, simdjson::error_code code) {
  // Where nlohmann's reader finds nothing, a number is too large.
  return InvalidInput({find_fault(text, name)
                           .value_or(Diagnostic{Severity::kError, name, "$", "not-json",
                                                simdjson::error_message(code)})});
}

std::string excess(std::string_view text, const Limits& limits) {
  std::size_t values = 1, depth = 0;
  std::vector<std::size_t> keys(limits.keys == 0 ? 0 : 1);  // by level
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at++];
    if (c == '"') {
      at = skip_string(text, at);
    } else if (c == ',' || c == ':') {
      ++values;
      if (c == ':' && limits.keys > 0 && ++keys[depth] > limits.keys) {
        return fmt::format("an object of more than {} keys", limits.keys);
      }
    } else if (c == '[' || c == '{') {
      ++values;
      if (++depth > limits.depth) return fmt::format("more than {} levels", limits.depth);
      if (limits.keys > 0) {
        keys.resize(std::max(keys.size(), depth + 1));
        keys[depth] = 0;
      }
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
    if (values > limits.values) {
      return fmt::format("more than {} values and keys", limits.values);
    }
  }
  return {};
}

std::string describe(Element element) {
  switch (element.type()) {
    case simdjson::dom::element_type::ARRAY:
      return fmt::format("array of {}", element.get_array().value_unsafe().size());
    case simdjson::dom::element_type::OBJECT:
      return "object";
    case simdjson::dom::element_type::INT64:
      return fmt::format("number {}", element.get_int64().value_unsafe());
    case simdjson::dom::element_type::UINT64:
      return fmt::format("number {}", element.get_uint64().value_unsafe());
    case simdjson::dom::element_type::DOUBLE:
      return fmt::format("number {}", element.get_double().value_unsafe());
    case simdjson::dom::element_type::STRING: {
      const std::string_view text = element.get_string().value_unsafe();
      return "string " + quote(text);
    }
    case simdjson::dom::element_type::BOOL:
      return element.get_bool().value_unsafe() ? "true" : "false";
    case simdjson::dom::element_type::NULL_VALUE:
      return "null";
  }
  return "something else";
}

std::optional<double> number(Element element, const Path& path, Faults& faults) {
  return read<double>(element, path, faults, "not-a-number", "a number");
}

std::optional<double> angle(Element element, const Path& path, Faults& faults) {
  const auto radians = number(element, path, faults);
  if (!radians || std::abs(*radians) <= kMostRadians) return radians;
  faults.error(path, "bad-angle",
               fmt::format("{} radians, not from {} to {}", *radians, -kMostRadians, kMostRadians));
  return std::nullopt;
}

std::optional<std::int64_t> integer(Element element, const Path& path, Faults& faults) {
  return read<std::int64_t>(element, path, faults, "not-an-integer", "a whole number");
}

std::optional<bool> boolean(Element element, const Path& path, Faults& faults) {
  return read<bool>(element, path, faults, "not-a-boolean", "true or false");
}

std::optional<std::string_view> string(Element element, const Path& path, Faults& faults) {
  return read<std::string_view>(element, path, faults, "not-a-string", "a string");
}

std::optional<std::string_view> id(Element element, const Path& path, Faults& faults,
                                   std::size_t most) {
  const auto text = string(element, path, faults);
  if (!text || is_id(*text, most)) return text;
  faults.error(path, "bad-id", fault_of_id(*text, most));
  return std::nullopt;
}

std::optional<simdjson::dom::array> array(Element element, const Path& path, Faults& faults) {
  return read<simdjson::dom::array>(element, path, faults, "not-an-array", "an array");
}

std::optional<simdjson::dom::object> object(Element element, const Path& path, Faults& faults) {
  return read<simdjson::dom::object>(element, path, faults, "not-an-object", "an object");
}

bool fields(Element element, std::span<const Field> wanted, std::span<std::optional<Element>> found,
            const Path& path, Faults& faults) {
  const auto members = object(element, path, faults);
  if (!members) return false;
  bool good = true;
  for (const auto member : *members) {
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      if (member.key != wanted[i].name) continue;
      if (found[i]) {
        faults.error(Path(path, wanted[i].name), "repeated-field", "given twice in one object");
        good = false;
      }
      found[i] = member.value;
    }
  }
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (found[i] || !wanted[i].required) continue;
    faults.error(path, "missing-field", fmt::format("has no field {:?}", wanted[i].name));
    good = false;
  }
  return good;
}

std::optional<Element> field(Element element, Field wanted, const Path& path, Faults& faults) {
  std::optional<Element> found;
  fields(element, {&wanted, 1}, {&found, 1}, path, faults);
  return found;
}

bool refuse_others(Element element, std::span<const Field> allowed, const Path& path,
                   Faults& faults) {
  simdjson::dom::object members;
  if (element.get_object().get(members) != simdjson::SUCCESS) return true;
  std::vector<std::string_view> names;
  for (const Field& field : allowed) names.push_back(field.name);
  bool good = true;
  for (const auto member : members) {
    if (std::ranges::find(names, member.key) != names.end()) continue;
    good = false;
    faults.error(
        path, "unknown-field",
        fmt::format("unknown field {}; {}", quote(member.key), advice_on_name(member.key, names)));
    if (faults.full()) break;
  }
  return good;
}

std::vector<std::string> strings(Element element, const Path& path, Faults& faults) {
  return list_of(element, path, faults, string);
}

std::vector<std::string> ids(Element element, const Path& path, Faults& faults) {
  return list_of(element, path, faults, [](Element one, const Path& place, Faults& found) {
    return id(one, place, found);
  });
}

}  // namespace enfilade::json
