#include "enfilade/core/detail/json_records.h"

#include <fmt/format.h>
#include <new>
#include <utility>

namespace enfilade::json {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

bool begins_list(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  return first != std::string_view::npos && text[first] == '[';
}

}  // namespace

Records::Records(std::string_view text, std::string name, std::size_t most_bytes)
    : name_(std::move(name)), most_bytes_(most_bytes), rest_(without_byte_order_mark(text)) {
  if (!begins_list(rest_)) return;
  list_.emplace(text, name_, most_bytes);
  Faults none(name_);
  list_->is_list(none);  // it is; this is where its entries begin
}

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

std::size_t Records::index() const noexcept { return list_ ? list_->index() : index_; }
std::size_t Records::bytes() const noexcept { return list_ ? list_->bytes() : bytes_; }
const std::optional<Element>& Records::element() const noexcept {
  return list_ ? list_->element() : element_;
}

}  // namespace enfilade::json
