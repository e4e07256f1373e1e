// Words and their ids, as in Room-to-Room's released code.
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <vector>

#include "enfilade/tasks/tokenizer.h"
#include "python/src/bindings.h"

namespace enfilade::python {

using tasks::Vocabulary;
using namespace nb::literals;

void bind_tokens(nb::module_& m) {
  m.def("tokenize", &tasks::tokenize, "text"_a,
        "Splits a text into words, as R2R's released code does.");
  nb::class_<Vocabulary>(m, "Vocabulary", "Words and their ids: 0 <PAD>, 1 <UNK>, 2 <EOS>.")
      .def_static(
          "load", &Vocabulary::load, "file"_a,
          "Reads one word per line, as in R2R's train_vocab.txt. Raises FileError, InvalidInput.")
      .def_static(
          "build",
          [](const std::vector<std::string>& texts, std::size_t least_count) {
            return Vocabulary::build(texts, least_count);
          },
          "texts"_a, "least_count"_a = 5,
          "The words with at least least_count occurrences, most frequent first; ties by alphabet.")
      .def("save", &Vocabulary::save, "file"_a, "Writes a file for load(). Raises FileError.")
      .def("__len__", &Vocabulary::size)
      .def_prop_ro("words", &Vocabulary::words, "Words by id.")
      .def("encode", &Vocabulary::encode, "text"_a, "length"_a = 80,
           "Token ids: words reversed, <EOS>, then <PAD> up to `length`.")
      .def(
          "decode",
          [](const Vocabulary& v, const std::vector<std::uint32_t>& ids) { return v.decode(ids); },
          "ids"_a, "Words in reading order, without <PAD> and <EOS>; unknown ids become <UNK>.")
      .def("__getstate__", &Vocabulary::words)
      .def("__setstate__", [](Vocabulary& v, const std::vector<std::string>& words) {
        new (&v) Vocabulary(Vocabulary::of(words));
      });
}

}  // namespace enfilade::python
