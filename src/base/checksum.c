/* checksum.c - the checksum of checksum.h: the sum of a hash of each word of 8 bytes and its place. */
#include <errno.h>
#include <unistd.h>
#include "base/checksum.h"

uint64_t MPMChecksum(const void *data, size_t bytes, size_t from)
{
  const char *at  = (const char *)data;
  uint64_t    sum = 0, place = (from / 8) * 0x9e3779b97f4a7c15ULL, word;

  for (; bytes >= 8; bytes -= 8, at += 8, place += 0x9e3779b97f4a7c15ULL) {
    memcpy(&word, at, 8);
    sum += MPMMix(word + MPMMix(place));
  }
  if (!bytes) return sum;
  word = 0;
  memcpy(&word, at, bytes);
  return sum + MPMMix(word + MPMMix(place));
}

int MPMChecksumFile(int file, size_t from, size_t to, uint64_t *sum)
{
  const size_t most = 1 << 20;
  char        *part = malloc(most);
  int          code = part ? 0 : ENOMEM;

  while (from < to && !code) {
    const size_t  wanted = PetscMin(most, to - from);
    const ssize_t n      = pread(file, part, wanted, (off_t)from);

    if (n < 0 && errno == EINTR) continue;
    if (n <= 0 || (size_t)n < PetscMin(8, wanted))
      code = n < 0 ? errno : EIO; /* it is shorter than it was */
    else {
      const size_t whole = (size_t)n == wanted ? wanted : (size_t)n / 8 * 8;

      *sum += MPMChecksum(part, whole, from);
      from += whole;
    }
  }
  free(part);
  return code;
}
