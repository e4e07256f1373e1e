/// \file  Writes Python's pickles, protocol 2: just what a graph needs.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace enfilade::exports::detail {

/// A stack machine's program; each function adds instructions that push one value, or take values
/// from the stack. Opcodes: Lib/pickletools.py of Python.
class PickleWriter {
 public:
  PickleWriter();

  // Push one value.
  void text(std::string_view utf8);
  void number(double value);
  void empty_dictionary();
  void empty_list();
  void empty_tuple();
  void global(std::string_view module, std::string_view name);  ///< a class or function

  void mark();           ///< begins what set_items() or append_items() take
  void set_items();      ///< keys and values since mark(), into the dictionary below it
  void append_items();   ///< values since mark(), into the list below it
  void make_object();    ///< class, arguments -> cls.__new__(cls, *arguments)
  void set_state();      ///< object, dictionary -> the object, with the dictionary's attributes
  std::uint32_t keep();  ///< gives the top value a number; it stays on the stack
  void again(std::uint32_t kept);  ///< pushes that very object again

  std::string finish();  ///< the pickle, whose value is the top of the stack

 private:
  void add_32(std::uint32_t value);
  std::string bytes_;
  std::uint32_t kept_ = 0;
};

}  // namespace enfilade::exports::detail
