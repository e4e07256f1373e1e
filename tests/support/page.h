/// \file  A report's page, for tests: its data, and what a browser makes of it.
#pragma once
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "enfilade/core/base64.h"
#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::report::testing {

/// How often a text has a part.
inline std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

/// What the page draws.
inline nlohmann::json data_of(const std::string& page) {
  const std::size_t tag = page.find("<script type=\"application/json\"");
  const std::size_t begin = page.find('>', tag) + 1;
  return nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
}

/// The content of a picture's address, "data:image/svg+xml;base64,...".
inline std::string decoded(const std::string& uri) {
  const std::string_view base64 = std::string_view(uri).substr(uri.find(',') + 1);
  std::string text(base64_bytes(base64).value_or(0), '\0');
  EXPECT_EQ(decode_base64(base64, std::as_writable_bytes(std::span(text))), std::string_view::npos);
  return text;
}

/// The program's name; nothing if there is none.
inline std::optional<std::string> find_browser() {
  for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
    if (std::system(fmt::format("command -v {} >/dev/null 2>&1", name).c_str()) == 0) return name;
  }
  return std::nullopt;
}

/// The document as the browser has it once all scripts have run.
inline std::string open_in_browser(const std::string& browser, const std::filesystem::path& page) {
  const tests::TemporaryFolder profile("browser");
  const std::filesystem::path dom = profile.path() / "dom.html";
  const std::string command = fmt::format(
      "timeout 200 {} --headless --no-sandbox --disable-gpu --disable-quic --no-first-run "
      "--disable-background-networking --disable-component-update --disable-sync "
      "--user-data-dir='{}' --virtual-time-budget=20000 --dump-dom 'file://{}' >'{}' 2>/dev/null",
      browser, profile.path().string(), page.string(), dom.string());
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 0) << command;
  return read_file(dom);
}

}  // namespace enfilade::report::testing
