#include "enfilade/exports/detail/pickle_writer.h"

#include <bit>
#include <utility>

namespace enfilade::exports::detail {

PickleWriter::PickleWriter() : bytes_("\x80\x02") {}

void PickleWriter::add_32(std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) {
    bytes_ += static_cast<char>(value >> static_cast<unsigned>(shift) & 0xFFU);
  }
}

void PickleWriter::text(std::string_view utf8) {
  bytes_ += 'X';
  add_32(static_cast<std::uint32_t>(utf8.size()));
  bytes_ += utf8;
}

void PickleWriter::number(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  bytes_ += 'G';
  for (int shift = 56; shift >= 0; shift -= 8) {
    bytes_ += static_cast<char>(bits >> static_cast<unsigned>(shift) & 0xFFU);
  }
}

void PickleWriter::empty_dictionary() { bytes_ += '}'; }
void PickleWriter::empty_list() { bytes_ += ']'; }
void PickleWriter::empty_tuple() { bytes_ += ')'; }

void PickleWriter::global(std::string_view module, std::string_view name) {
  bytes_ += 'c';
  bytes_ += module;
  bytes_ += '\n';
  bytes_ += name;
  bytes_ += '\n';
}

void PickleWriter::mark() { bytes_ += '('; }
void PickleWriter::set_items() { bytes_ += 'u'; }
void PickleWriter::append_items() { bytes_ += 'e'; }
void PickleWriter::make_object() { bytes_ += '\x81'; }
void PickleWriter::set_state() { bytes_ += 'b'; }

std::uint32_t PickleWriter::keep() {
  bytes_ += 'r';
  add_32(kept_);
  return kept_++;
}

void PickleWriter::again(std::uint32_t kept) {
  bytes_ += 'j';
  add_32(kept);
}

std::string PickleWriter::finish() {
  bytes_ += '.';
  return std::move(bytes_);
}

}  // namespace enfilade::exports::detail
