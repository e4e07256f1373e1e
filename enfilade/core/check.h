/// \file  EN_CHECK: assertions of Enfilade's own invariants. Mistakes of a caller or of a file are
/// exceptions instead (errors.h).
#pragma once
#include <sstream>
#include <string>

namespace enfilade::detail {

/// Prints the failed expression with both values to stderr and aborts: after a broken invariant no
/// result can be trusted.
[[noreturn]] void check_failed(const char* file, int line, const char* expression,
                               const std::string& values);

template <class A, class B>
std::string show_values(const A& a, const B& b) {
  std::ostringstream out;
  out << a << " vs " << b;
  return out.str();
}

}  // namespace enfilade::detail

/// Aborts, naming file and line, if the condition does not hold. For invariants only.
#define EN_CHECK(condition)                                                 \
  do {                                                                      \
    if (!(condition)) [[unlikely]]                                          \
      ::enfilade::detail::check_failed(__FILE__, __LINE__, #condition, ""); \
  } while (false)

/// As EN_CHECK, for a comparison: the message has both values. Each is evaluated once.
#define EN_CHECK_OP(a, op, b)                                                                    \
  do {                                                                                           \
    const auto& en_check_a = (a);                                                                \
    const auto& en_check_b = (b);                                                                \
    if (!(en_check_a op en_check_b)) [[unlikely]]                                                \
      ::enfilade::detail::check_failed(__FILE__, __LINE__, #a " " #op " " #b,                    \
                                       ::enfilade::detail::show_values(en_check_a, en_check_b)); \
  } while (false)

/// EN_CHECK_OP with ==, < and <=.
#define EN_CHECK_EQ(a, b) EN_CHECK_OP(a, ==, b)
#define EN_CHECK_LT(a, b) EN_CHECK_OP(a, <, b)
#define EN_CHECK_LE(a, b) EN_CHECK_OP(a, <=, b)
