/* What Debian 12's static libraries want of a C library newer than the wheel's. Linked into all that a
 * wheel has, hidden; see docs/design/wheel.md. */
#include <stddef.h>
#include <stdint.h>
#include <sys/random.h>

/* glibc 2.32: may atomic counters do without atomic instructions? 0 is always safe. */
__attribute__((visibility("hidden"))) char __libc_single_threaded = 0;

/* glibc 2.36, used by std::random_device and by OpenSSL or SQLite. getentropy gives at most 256 bytes a call,
 * and cannot fail for them on a kernel that has it (3.17). */
__attribute__((visibility("hidden"))) void arc4random_buf(void* memory, size_t size) {
  for (unsigned char* at = memory; size > 0;) {
    const size_t now = size < 256 ? size : 256;
    if (getentropy(at, now) != 0) __builtin_trap();
    at += now;
    size -= now;
  }
}

__attribute__((visibility("hidden"))) uint32_t arc4random(void) {
  uint32_t value = 0;
  arc4random_buf(&value, sizeof value);
  return value;
}
