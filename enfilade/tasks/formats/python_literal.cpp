#include "enfilade/tasks/formats/python_literal.h"

#include <fmt/format.h>
#include <charconv>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "enfilade/core/names.h"
#include "enfilade/core/utf8.h"

namespace enfilade::tasks::formats {
namespace {

constexpr std::size_t kShownBytes = 12;  // of what was found

class LiteralReader {
 public:
  explicit LiteralReader(std::string_view text) : text_(text) {}

  bool read(WordLists& lists) {
    const auto words = [this](std::vector<std::string>& piece) {
      return list(piece, "a word in quotes", [this](std::string& word) { return string(word); });
    };
    const auto pieces = [&](std::vector<std::vector<std::string>>& instruction) {
      return list(instruction, "the list of a piece", words);
    };
    if (!list(lists, "the list of an instruction", pieces)) return false;
    skip_blanks();
    return at_ == text_.size() || refuse("the end of the text");
  }
  LiteralFault take_fault() { return std::move(fault_); }

 private:
  // \param what  an element is, for messages
  template <class T, class ReadElement>
  bool list(std::vector<T>& elements, std::string_view what, const ReadElement& read_element) {
    skip_blanks();
    if (!take('[')) return refuse("a list, which begins with [");
    for (;;) {
      skip_blanks();
      if (take(']')) return true;
      const char first = at_ < text_.size() ? text_[at_] : '\0';
      const bool fits =
          std::is_same_v<T, std::string> ? first == '\'' || first == '"' : first == '[';
      if (!fits) return refuse(fmt::format("{} or ]", what));
      if (!read_element(elements.emplace_back())) return false;
      skip_blanks();
      if (take(',')) continue;
      return take(']') || refuse(", or ]");
    }
  }

  // \pre a quotation mark is next
  bool string(std::string& word) {
    const std::size_t begin = at_;
    const char quote = text_[at_++];
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == quote) {
        ++at_;
        return true;
      }
      if (static_cast<unsigned char>(c) < 0x20 && c != '\t') {
        return refuse("an escape such as \\n instead of a control character");
      }
      if (c == '\\') {
        if (!escape(word)) return false;
        continue;
      }
      word += c;
      ++at_;
    }
    return refuse(fmt::format("{}, which ends the string that begins at byte {}", quote, begin));
  }

  // \pre a backslash is next
  bool escape(std::string& word) {
    const char kind = at_ + 1 < text_.size() ? text_[at_ + 1] : '\0';
    switch (kind) {
      case '\\':
      case '\'':
      case '"':
        return simple_escape(kind, word);
      case 'n':
        return simple_escape('\n', word);
      case 'r':
        return simple_escape('\r', word);
      case 't':
        return simple_escape('\t', word);
      case 'x':
        return code_escape(2, word);
      case 'u':
        return code_escape(4, word);
      case 'U':
        return code_escape(8, word);
      default:
        return refuse(R"(one of the escapes \\ \' \" \n \r \t \x \u \U)");
    }
  }
  bool simple_escape(char c, std::string& word) {
    word += c;
    at_ += 2;
    return true;
  }
  bool code_escape(std::size_t digits, std::string& word) {
    const std::string_view hex = text_.substr(at_ + 2, digits);
    std::uint32_t code = 0;
    const auto [stop, error] = std::from_chars(hex.data(), hex.data() + hex.size(), code, 16);
    if (error != std::errc() || hex.size() < digits || stop != hex.data() + digits) {
      return refuse(fmt::format("{} hexadecimal digits", digits));
    }
    if (code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) {
      return refuse("the code of a character: up to 10ffff, without d800 to dfff");
    }
    append_utf8(code, word);
    at_ += 2 + digits;
    return true;
  }

  void skip_blanks() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != text_.npos) ++at_;
  }
  bool take(char c) {
    if (at_ == text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  bool refuse(std::string_view expected) {
    const std::string_view found = text_.substr(at_, kShownBytes);
    fault_ = {at_, found.empty() ? fmt::format("the text ends; {} is expected", expected)
                                 : fmt::format("{}; {} is expected", quote(found), expected)};
    return false;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  LiteralFault fault_;
};

void append_string(const std::string& word, std::string& text) {
  const bool both = word.find('\'') != word.npos && word.find('"') == word.npos;
  const char quote = both ? '"' : '\'';
  text += quote;
  for (const char c : word) {
    const auto code = static_cast<unsigned char>(c);
    if (c == quote || c == '\\') {
      text += '\\';
      text += c;
    } else if (c == '\n') {
      text += "\\n";
    } else if (c == '\r') {
      text += "\\r";
    } else if (c == '\t') {
      text += "\\t";
    } else if (code < 0x20 || code == 0x7f) {
      text += fmt::format("\\x{:02x}", code);
    } else {
      text += c;
    }
  }
  text += quote;
}

// `append(element, text)` for each, between brackets and commas.
template <class T, class Append>
void append_list(const std::vector<T>& elements, std::string& text, const Append& append) {
  text += '[';
  for (std::size_t k = 0; k < elements.size(); ++k) {
    if (k > 0) text += ", ";
    append(elements[k], text);
  }
  text += ']';
}

}  // namespace

std::optional<LiteralFault> read_word_lists(std::string_view text, WordLists& lists) {
  lists.clear();
  LiteralReader reader(text);
  if (reader.read(lists)) return std::nullopt;
  return reader.take_fault();
}

std::string write_word_lists(const WordLists& lists) {
  std::string text;
  append_list(lists, text, [](const auto& instruction, std::string& to) {
    append_list(instruction, to, [](const auto& piece, std::string& into) {
      append_list(piece, into, append_string);
    });
  });
  return text;
}

}  // namespace enfilade::tasks::formats
