#include "enfilade/core/detail/json_entries.h"

#include <fmt/format.h>
#include <array>
#include <new>
#include <utility>

#include "enfilade/core/threads.h"
#include "enfilade/core/utf8.h"

namespace enfilade::json {
namespace {

constexpr std::size_t kStart = static_cast<std::size_t>(-1);  // before the first entry

// What the search for the end of an entry has to look at. The rest is left to simdjson.
enum Kind : unsigned char { kOther, kQuote, kOpen, kClose, kComma };

constexpr std::array<Kind, 256> make_kinds() {
  std::array<Kind, 256> kinds{};
  kinds['"'] = kQuote;
  kinds['['] = kinds['{'] = kOpen;
  kinds[']'] = kinds['}'] = kClose;
  kinds[','] = kComma;
  return kinds;
}
constexpr std::array<Kind, 256> kKinds = make_kinds();

// The place of the comma or bracket after a value; the text's end if there is none. Takes no notice
// of which bracket closes which: simdjson does.
std::size_t end_of_value(std::string_view text, std::size_t at) {
  std::size_t depth = 0;
  for (; at < text.size(); ++at) {
    switch (kKinds[static_cast<unsigned char>(text[at])]) {
      case kOther:
        break;
      case kQuote:
        at = skip_string(text, at + 1) - 1;
        break;
      case kOpen:
        ++depth;
        break;
      case kClose:
        if (depth == 0) return at;
        --depth;
        break;
      case kComma:
        if (depth == 0) return at;
        break;
    }
  }
  return text.size();
}

std::size_t after_blanks(std::string_view text, std::size_t at) {
  while (at < text.size() && std::string_view(" \t\n\r").find(text[at]) != text.npos) ++at;
  return at;
}

// A part of a text that is one level down in it.
simdjson::error_code parse_part(simdjson::dom::parser& parser, std::string_view text,
                                std::size_t begin, std::size_t end, Element& element) {
  const std::size_t bytes = end - begin;
  // The parser would forget how deep it may go when it grows.
  if (parser.capacity() < bytes) {
    const auto code = parser.allocate(bytes, simdjson::DEFAULT_MAX_DEPTH - 1);
    if (code != simdjson::SUCCESS) throw std::bad_alloc();
  }
  // simdjson looks at some bytes after the text that it is given. If there are none that belong to
  // us, it has to copy it.
  const bool copies = text.size() - end < simdjson::SIMDJSON_PADDING;
  const simdjson::error_code code = parser.parse(text.data() + begin, bytes, copies).get(element);
  if (code == simdjson::MEMALLOC) throw std::bad_alloc();
  return code;
}

}  // namespace

Entries::Entries(std::string_view text, std::string name, std::size_t most_bytes)
    : text_(without_byte_order_mark(text)),
      name_(std::move(name)),
      most_bytes_(most_bytes),
      index_(kStart) {}

bool Entries::is_list(Faults& faults) {
  skip_blanks();
  const char first = at_ < text_.size() ? text_[at_] : '\0';
  if (first == '[') return true;
  // A whole parse of an object would take many times the text's bytes.
  check_syntax(text_, name_);
  const std::string found =
      first == '{' ? "object" : describe(Document::parse(text_, name_).root());
  faults.error(Path(), "not-an-array", fmt::format("{}, not an array", found));
  return false;
}

bool Entries::next() {
  // at_ is at what stands before the entry: the list's bracket, or the last entry's comma
  const bool first = index_ == kStart;
  bool ended = !first && text_[at_] == ']';
  if (!ended) {
    ++at_;
    skip_blanks();
    ended = first && at_ < text_.size() && text_[at_] == ']';
  }
  if (ended) {
    ++at_;
    skip_blanks();
    if (at_ < text_.size()) refuse(simdjson::TAPE_ERROR);
    return false;
  }
  const std::size_t begin = at_;
  element_.reset();
  if (!take_plain_object(begin)) take_any(begin);
  const char after = at_ < text_.size() ? text_[at_] : '\0';
  if (after != ',' && after != ']') refuse(simdjson::TAPE_ERROR);
  ++index_;
  return true;
}

// An object without objects in it ends at the first brace. Whether the entry is one, simdjson says:
// if the text up to there is an object, it is the entry, as no object begins with another one. That
// saves the search for its end, which takes as long as the parse.
bool Entries::take_plain_object(std::size_t begin) {
  if (!plain_ || begin == text_.size() || text_[begin] != '{') return false;
  const std::size_t brace = text_.find('}', begin);
  // Tried until it fails once: the search and the parse may have been in vain.
  plain_ = brace != std::string_view::npos && brace - begin < most_bytes_ &&
           parse(begin, brace + 1) == simdjson::SUCCESS;
  if (!plain_) return false;
  at_ = brace + 1;
  skip_blanks();
  return true;
}

void Entries::take_any(std::size_t begin) {
  at_ = end_of_value(text_, begin);
  bytes_ = at_ - begin;
  if (at_ == text_.size()) refuse(simdjson::TAPE_ERROR);  // the list has no end
  if (bytes_ > most_bytes_) return;
  const simdjson::error_code code = parse(begin, at_);
  if (code != simdjson::SUCCESS) refuse(code);
}

simdjson::error_code Entries::parse(std::size_t begin, std::size_t end) {
  bytes_ = end - begin;
  Element element;
  const simdjson::error_code code = parse_part(parser_, text_, begin, end, element);
  if (code == simdjson::SUCCESS) element_ = element;
  return code;
}

void Entries::skip_blanks() { at_ = after_blanks(text_, at_); }

void Entries::refuse(simdjson::error_code code) const { throw not_json(text_, name_, code); }

Members::Members(std::string_view text, std::string name)
    : text_(without_byte_order_mark(text)), name_(std::move(name)) {}

bool Members::is_object(Faults& faults) {
  skip_blanks();
  if (at_ < text_.size() && text_[at_] == '{') return true;
  // A whole parse of a list would take many times the text's bytes.
  check_syntax(text_, name_);
  const std::string found = at_ < text_.size() && text_[at_] == '['
                                ? "array"
                                : describe(Document::parse(text_, name_).root());
  faults.error(Path(), "not-an-object", fmt::format("{}, not an object", found));
  return false;
}

bool Members::next() {
  // at_ is at what stands before the member: the object's brace, or the last member's comma
  bool ended = !first_ && text_[at_] == '}';
  if (!ended) {
    ++at_;
    skip_blanks();
    ended = first_ && at_ < text_.size() && text_[at_] == '}';
  }
  if (ended) {
    ++at_;
    skip_blanks();
    if (at_ < text_.size()) refuse(simdjson::TAPE_ERROR);
    return false;
  }
  first_ = false;
  key_ = read_key();
  skip_blanks();
  if (at_ == text_.size() || text_[at_] != ':') refuse(simdjson::TAPE_ERROR);
  begin_ = after_blanks(text_, at_ + 1);
  at_ = end_of_value(text_, begin_);
  if (at_ == text_.size() || at_ == begin_ || text_[at_] == ']') refuse(simdjson::TAPE_ERROR);
  return true;
}

std::optional<Element> Members::element(std::size_t most_bytes) {
  if (at_ - begin_ > most_bytes) return std::nullopt;
  Element element;
  const simdjson::error_code code = parse_part(parser_, text_, begin_, at_, element);
  if (code != simdjson::SUCCESS) refuse(code);
  return element;
}

std::string Members::read_key() {
  if (at_ == text_.size() || text_[at_] != '"') refuse(simdjson::TAPE_ERROR);
  const std::size_t begin = at_;
  at_ = skip_string(text_, begin + 1);
  Element element;
  std::string_view key;
  const simdjson::error_code code = parse_part(parser_, text_, begin, at_, element);
  if (code != simdjson::SUCCESS || element.get(key) != simdjson::SUCCESS) refuse(code);
  return std::string(key);
}

void Members::skip_blanks() { at_ = after_blanks(text_, at_); }

void Members::refuse(simdjson::error_code code) const { throw not_json(text_, name_, code); }

namespace {

constexpr std::string_view kBlanks = " \t\r\n";

bool begins_list(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  return first != std::string_view::npos && text[first] == '[';
}

// Records and lines; a last line may have no end.
Records::Begin count_lines(std::string_view text) {
  Records::Begin count;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    count.record += line.find_first_not_of(kBlanks) == std::string_view::npos ? 0 : 1;
    ++count.line;
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return count;
}

}  // namespace

Records::Records(std::string_view text, std::string name, std::size_t most_bytes)
    : name_(std::move(name)), most_bytes_(most_bytes), rest_(without_byte_order_mark(text)) {
  if (!begins_list(rest_)) return;
  list_.emplace(text, name_, most_bytes);
  Faults none(name_);
  list_->is_list(none);  // it is; this is where its entries begin
}

Records::Records(std::string_view lines, std::string name, std::size_t most_bytes, Begin begin)
    : name_(std::move(name)),
      most_bytes_(most_bytes),
      rest_(lines),
      line_(begin.line),
      index_(begin.record - 1) {}

bool Records::next() { return list_ ? list_->next() : next_line(); }

bool Records::next_line() {
  std::string_view line;
  do {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++line_;
  } while (line.find_first_not_of(kBlanks) == std::string_view::npos);
  ++index_;
  bytes_ = line.size();
  element_.reset();
  if (bytes_ > most_bytes_) return true;
  Element element;
  const simdjson::error_code code = parser_.parse(line.data(), line.size()).get(element);
  if (code == simdjson::MEMALLOC) throw std::bad_alloc();
  if (code != simdjson::SUCCESS) throw not_json(line, fmt::format("{}:{}", name_, line_), code);
  element_ = element;
  return true;
}

Parts split_records(std::string_view text, std::size_t part_bytes) {
  const std::string_view lines = without_byte_order_mark(text);
  if (begins_list(lines)) return {false, {text}, {Records::Begin()}};
  Parts parts{true, {}, {}};
  for (std::string_view rest = lines; !rest.empty();) {
    const std::size_t end =
        rest.size() <= part_bytes ? std::string_view::npos : rest.find('\n', part_bytes - 1);
    parts.texts.push_back(rest.substr(0, end == std::string_view::npos ? end : end + 1));
    rest.remove_prefix(parts.texts.back().size());
  }
  if (parts.texts.empty()) parts.texts.emplace_back();
  parts.begins.resize(parts.texts.size());  // for now: how much each has
  parallel_for(parts.texts.size(), 1, 0, [&parts](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) parts.begins[k] = count_lines(parts.texts[k]);
  });
  Records::Begin sum;
  for (Records::Begin& one : parts.begins) {
    const Records::Begin count = std::exchange(one, sum);
    sum = {sum.record + count.record, sum.line + count.line};
  }
  return parts;
}

std::size_t Records::index() const noexcept { return list_ ? list_->index() : index_; }
std::size_t Records::bytes() const noexcept { return list_ ? list_->bytes() : bytes_; }
const std::optional<Element>& Records::element() const noexcept {
  return list_ ? list_->element() : element_;
}

}  // namespace enfilade::json
