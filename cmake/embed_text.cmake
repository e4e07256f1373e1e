# Makes a C++ source out of text files, so that a program carries them in itself. A build step:
#
#   cmake -DOUTPUT=x.cpp -DHEADER=a/b.h -DNAMESPACE=a::b "-DTEXTS=kOne=f.js|g.js,kTwo=h.css" -P ...
#
# defines in NAMESPACE, for each NAME=FILES, `const std::string_view NAME`, its files one after the
# other.
set(source "// Made by cmake/embed_text.cmake.\n#include \"${HEADER}\"\n\nnamespace ${NAMESPACE} {\n")
string(REPLACE "," ";" texts "${TEXTS}")
foreach(text IN LISTS texts)
  string(REGEX MATCH "^([^=]+)=(.*)$" matched "${text}")
  set(name ${CMAKE_MATCH_1})
  string(REPLACE "|" ";" files "${CMAKE_MATCH_2}")
  string(APPEND source "namespace {\nconstexpr char ${name}Text[] =\n")
  foreach(file IN LISTS files)
    file(READ ${file} content)
    # A raw string each; strings beside each other are one.
    string(APPEND source "R\"en_text(${content})en_text\"\n")
  endforeach()
  string(APPEND source "\"\";\n}  // namespace\n"
    "const std::string_view ${name}{${name}Text, sizeof(${name}Text) - 1};\n")
endforeach()
string(APPEND source "}  // namespace ${NAMESPACE}\n")
file(WRITE ${OUTPUT} "${source}")
