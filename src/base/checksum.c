/* checksum.c - the checksum of checksum.h: the sum of a hash of each word of 8 bytes and its place. */
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
