/* unit.h - all that a unit test needs: checks that count, a stream of random numbers, and the last line.

   A test is a main() that calls CHECK.. and ends with `return UnitEnd();`: 0 if there were checks and all held, else 1.
   A check that fails prints where it stands, the context, the value and its bound; each place in a file prints its
   first three. */
#ifndef UNIT_H
#define UNIT_H

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

static long     unit_checks, unit_failures;
static char     unit_context[256];
static uint64_t unit_state = 0x9e3779b97f4a7c15ULL;

/* What is being checked now, for the lines of failures. */
__attribute__((format(printf, 1, 2), unused)) static void UnitContext(const char *format, ...)
{
  va_list args;

  va_start(args, format);
  vsnprintf(unit_context, sizeof unit_context, format, args);
  va_end(args);
}

__attribute__((unused)) static void UnitCheck(int ok, int *shown, const char *file, int line, const char *what,
                                              double value, const char *relation, double bound)
{
  unit_checks++;
  if (ok) return;
  unit_failures++;
  if ((*shown)++ >= 3) return;
  fprintf(stderr, "%s:%d: FAILED (%s) %s: %.17g, must be %s %.17g\n", file, line, unit_context, what, value, relation,
          bound);
}

#define UNIT_CHECK(ok, what, value, relation, bound)                                                                   \
  do {                                                                                                                 \
    static int unit_shown;                                                                                             \
    UnitCheck(ok, &unit_shown, __FILE__, __LINE__, what, (double)(value), relation, (double)(bound));                  \
  } while (0)

/* Comparisons are false for NaN, so a NaN fails all of these. Arguments are evaluated more than once. */
#define CHECK(condition)          UNIT_CHECK(condition, #condition, (condition) ? 1 : 0, "==", 1)
#define CHECK_EQ(value, expected) UNIT_CHECK((value) == (expected), #value, value, "==", expected)
#define CHECK_LE(value, bound)    UNIT_CHECK((value) <= (bound), #value, value, "<=", bound)
#define CHECK_GE(value, bound)    UNIT_CHECK((value) >= (bound), #value, value, ">=", bound)
#define CHECK_NEAR(value, expected, tolerance)                                                                         \
  UNIT_CHECK(fabs((double)((value) - (expected))) <= (tolerance), "|" #value " - " #expected "|",                      \
             fabs((double)((value) - (expected))), "<=", tolerance)
/* The same n bytes. */
#define CHECK_SAME(a, b, n) UNIT_CHECK(!memcmp(a, b, n), "bytes of " #a " and " #b " differ", 1, "==", 0)

/* splitmix64: the same numbers everywhere. */
__attribute__((unused)) static uint64_t UnitBits(void)
{
  uint64_t z = unit_state += 0x9e3779b97f4a7c15ULL;

  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/* Uniform in [lo, hi). */
__attribute__((unused)) static double UnitReal(double lo, double hi)
{
  return lo + (hi - lo) * (double)(UnitBits() >> 11) * 0x1p-53;
}

/* Uniform in 0 .. n-1. */
__attribute__((unused)) static int UnitInt(int n)
{
  return (int)(UnitBits() % (uint64_t)n);
}

/* x moved by k units in the last place. */
__attribute__((unused)) static double UnitStep(double x, int k)
{
  for (; k > 0; k--) x = nextafter(x, INFINITY);
  for (; k < 0; k++) x = nextafter(x, -INFINITY);
  return x;
}

/* The last line; the exit status, which is 1 too if nothing was checked. */
__attribute__((unused)) static int UnitEnd(void)
{
  printf("%ld checks, %ld failed\n", unit_checks, unit_failures);
  return unit_failures || !unit_checks ? 1 : 0;
}

#endif
