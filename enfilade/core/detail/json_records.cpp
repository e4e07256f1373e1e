#include "enfilade/core/detail/json_records.h"

#include <fmt/format.h>
#include <new>
#include <utility>

#include "enfilade/core/threads.h"

namespace enfilade::json {
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
