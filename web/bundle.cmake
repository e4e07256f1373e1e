# Builds the web client with npm, where there is one, and makes a C++ source out of its files:
# sets web_files_source. Without npm, or Node.js new enough, the source is an empty list, and the server has no
# pages. A source distribution brings that source instead of the client's.
set(web_files_source ${CMAKE_CURRENT_BINARY_DIR}/web_files.cpp)
set(web_files_made ${PROJECT_SOURCE_DIR}/packaging/made/web_files.cpp)
set(web ${PROJECT_SOURCE_DIR}/web)
set(web_dist ${CMAKE_CURRENT_BINARY_DIR}/web)
find_program(NPM_PROGRAM npm DOC "npm, which builds the web client; OFF: without web client")
set(web_lacks "")
if(NPM_PROGRAM)
  execute_process(COMMAND node --version OUTPUT_VARIABLE web_node OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  string(REGEX REPLACE "^v" "" web_node "${web_node}")
  if(web_node VERSION_LESS 20.19)  # Debian 12's
    set(web_lacks "Node.js 20.19 or newer is not on this machine")
  elseif(SKBUILD AND EXISTS ${web}/src)  # pip: with npm's registry out of reach, the rest is built all the same
    execute_process(COMMAND ${CMAKE_COMMAND} -DWEB=${web} -DNPM=${NPM_PROGRAM} -P ${web}/install.cmake
      RESULT_VARIABLE web_failed OUTPUT_QUIET)
    if(web_failed)
      set(web_lacks "npm could not fetch what the web client is built with")
    endif()
  endif()
else()
  set(web_lacks "npm is not on this machine")
endif()
if(NOT EXISTS ${web}/src AND EXISTS ${web_files_made})
  set(web_files_source ${web_files_made})
elseif(NOT web_lacks)
  # Looked up when CMake runs, which ./enfilade.sh has it do each time: with CONFIGURE_DEPENDS a build
  # would not know its steps before it begins.
  file(GLOB_RECURSE web_sources ${web}/src/* ${web}/pages/*)
  list(FILTER web_sources EXCLUDE REGEX "/testing/|[.]test[.]ts$")  # unit tests are in no page
  set(web_installed ${web}/node_modules/.package-lock.json)
  add_custom_command(OUTPUT ${web_installed}
    COMMAND ${CMAKE_COMMAND} -DWEB=${web} -DNPM=${NPM_PROGRAM} -P ${web}/install.cmake
    DEPENDS ${web}/package-lock.json ${web}/install.cmake
    COMMENT "Fetching what the web client is built with (npm ci)"
    VERBATIM)
  add_custom_command(OUTPUT ${web_files_source}
    COMMAND ${CMAKE_COMMAND} -E env ENFILADE_WEB_DIST=${web_dist}
      ${NPM_PROGRAM} run --silent build
    COMMAND node ${web}/embed.mjs ${web_dist} ${web_files_source}
    WORKING_DIRECTORY ${web}
    DEPENDS ${web_installed} ${web_sources} ${web}/package.json ${web}/vite.config.ts
      ${web}/tsconfig.json ${web}/embed.mjs
    COMMENT "Building the web client"
    VERBATIM)
else()
  message(WARNING "${web_lacks}: the server will have no web client")
  file(WRITE ${web_files_source}.new "// Made by web/bundle.cmake: no npm, no files.
#include \"enfilade/service/http/web_files.h\"

namespace enfilade::service::http {
std::span<const WebFile> web_files() { return {}; }
}  // namespace enfilade::service::http
")
  configure_file(${web_files_source}.new ${web_files_source} COPYONLY)
endif()
