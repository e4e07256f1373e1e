/* What Debian 12's static libraries want of a C library newer than the wheel's. Linked into all that a
 * wheel has, hidden; see docs/design/wheel.md. */
#include <stddef.h>
#include <stdint.h>
#include <sys/random.h>

/* glibc 2.32: may atomic counters do without atomic instructions? 0 is always safe. */
__attribute__((visibility("hidden"))) char __libc_single_threaded = 0;

/* glibc 2.36, used by std::random_device. getentropy gives at most 256 bytes, and cannot fail for fewer
 * on a kernel that has it (3.17). */
__attribute__((visibility("hidden"))) uint32_t arc4random(void) {
  uint32_t value = 0;
  if (getentropy(&value, sizeof value) != 0) __builtin_trap();
  return value;
}
