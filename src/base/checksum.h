/* checksum.h - a checksum of a file that processes compute together, each from the parts that it has. */
#ifndef MPM_CHECKSUM_H
#define MPM_CHECKSUM_H

#include "base/base.h"

/* Permutes the 64-bit words; nearby words become unrelated ones (splitmix64's finaliser, Steele, Lea and Flood
   2014). */
MPM_INLINE uint64_t MPMMix(uint64_t z)
{
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/* Returns the checksum of `bytes` bytes of a file, which begin at its byte `from`, a multiple of 8; an incomplete last
   word counts as if zeros followed. The checksum of parts that follow each other is the sum of theirs, modulo 2^64. Not
   collective. */
uint64_t MPMChecksum(const void *data, size_t bytes, size_t from);

/* Adds to *sum the checksum of the bytes from .. to-1 of an open file; `from` is a multiple of 8, and so is `to` unless
   the file ends there. Returns 0, or errno. Not collective. */
int MPMChecksumFile(int file, size_t from, size_t to, uint64_t *sum);

#endif
