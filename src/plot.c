/* plot.c - a log-log plot as an SVG file, which any browser shows: the few lines that a study needs, so that its plot
   does not depend on another program being there.                                                                    */
#include <errno.h>
#include "mpm.h"

enum { WIDTH = 560, HEIGHT = 420, LEFT = 80, RIGHT = 20, TOP = 40, BOTTOM = 60 };

/* The range of decades around n values, as powers of 10. */
static void Decades(PetscInt n, const PetscReal v[], PetscReal *lo, PetscReal *hi)
{
  *lo = PETSC_MAX_REAL;
  *hi = PETSC_MIN_REAL;
  for (PetscInt k = 0; k < n; k++) {
    *lo = PetscMin(*lo, PetscLog10Real(v[k]) - 0.15);
    *hi = PetscMax(*hi, PetscLog10Real(v[k]) + 0.15);
  }
}

static double Place(PetscReal v, PetscReal lo, PetscReal hi, double from, double to)
{
  return from + (to - from) * (double)((PetscLog10Real(v) - lo) / (hi - lo));
}

/* Lines and numbers at 1, 2 and 5 times the powers of ten. */
static void Ticks(FILE *f, PetscBool horizontal, PetscReal lo, PetscReal hi)
{
  static const int digit[] = {1, 2, 5};

  for (int decade = (int)PetscFloorReal(lo); decade <= (int)PetscCeilReal(hi); decade++)
    for (int k = 0; k < 3; k++) {
      const PetscReal v = digit[k] * PetscPowReal(10, decade);

      if (PetscLog10Real(v) < lo || PetscLog10Real(v) > hi || (hi - lo > 3 && k)) continue;
      if (horizontal) {
        const double x = Place(v, lo, hi, LEFT, WIDTH - RIGHT);
        fprintf(f, "<path d='M%.1f %d V%d' stroke='#ddd'/><text x='%.1f' y='%d' text-anchor='middle'>%.3g</text>\n", x,
                TOP, HEIGHT - BOTTOM, x, HEIGHT - BOTTOM + 18, (double)v);
      } else {
        const double y = Place(v, lo, hi, HEIGHT - BOTTOM, TOP);
        fprintf(f, "<path d='M%d %.1f H%d' stroke='#ddd'/><text x='%d' y='%.1f' text-anchor='end'>%.3g</text>\n", LEFT,
                y, WIDTH - RIGHT, LEFT - 6, y + 4, (double)v);
      }
    }
}

/* Text of an XML file: < and & are marks there. */
static void Text(FILE *f, const char text[])
{
  for (const char *c = text; *c; c++) {
    if (*c == '<')
      fputs("&lt;", f);
    else if (*c == '&')
      fputs("&amp;", f);
    else
      fputc(*c, f);
  }
}

/* Writes y [n] over x [n], all positive, with a line of slope 2 through the last particle. Not collective. */
PetscErrorCode MPMPlotLogLog(const char path[], const char title[], const char xlabel[], const char ylabel[],
                             PetscInt n, const PetscReal x[], const PetscReal y[])
{
  PetscReal xlo, xhi, ylo, yhi;
  FILE     *f;

  PetscFunctionBeginUser;
  for (PetscInt k = 0; k < n; k++)
    if (!(x[k] > 0 && y[k] > 0 && y[k] < PETSC_MAX_REAL)) PetscFunctionReturn(PETSC_SUCCESS); /* nothing to draw */
  f = fopen(path, "w");
  PetscCheck(f, PETSC_COMM_SELF, PETSC_ERR_FILE_OPEN, "cannot write %s: %s", path, strerror(errno));
  Decades(n, x, &xlo, &xhi);
  Decades(n, y, &ylo, &yhi);
  fprintf(f,
          "<svg xmlns='http://www.w3.org/2000/svg' width='%d' height='%d' font-family='sans-serif' font-size='12'>\n",
          WIDTH, HEIGHT);
  fprintf(f,
          "<rect width='100%%' height='100%%' fill='white'/>\n<text x='%d' y='24' text-anchor='middle' font-size='15'>",
          (LEFT + WIDTH - RIGHT) / 2);
  Text(f, title);
  fprintf(f, "</text>\n");
  Ticks(f, PETSC_TRUE, xlo, xhi);
  Ticks(f, PETSC_FALSE, ylo, yhi);
  fprintf(f, "<rect x='%d' y='%d' width='%d' height='%d' fill='none' stroke='black'/>\n", LEFT, TOP,
          WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM);
  fprintf(f, "<clipPath id='c'><rect x='%d' y='%d' width='%d' height='%d'/></clipPath>\n", LEFT, TOP,
          WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM);
  fprintf(f, "<path clip-path='url(#c)' stroke='#888' stroke-dasharray='5 4' fill='none' d='M%.1f %.1f L%.1f %.1f'/>\n",
          Place(x[0], xlo, xhi, LEFT, WIDTH - RIGHT),
          Place(y[n - 1] * PetscSqr(x[0] / x[n - 1]), ylo, yhi, HEIGHT - BOTTOM, TOP),
          Place(x[n - 1], xlo, xhi, LEFT, WIDTH - RIGHT), Place(y[n - 1], ylo, yhi, HEIGHT - BOTTOM, TOP));
  fprintf(f, "<text x='%d' y='%d' text-anchor='end' fill='#888'>dashed: second order</text>\n", WIDTH - RIGHT - 8,
          HEIGHT - BOTTOM - 8);
  fprintf(f, "<path stroke='#1f77b4' stroke-width='2' fill='none' d='");
  for (PetscInt k = 0; k < n; k++)
    fprintf(f, "%c%.1f %.1f ", k ? 'L' : 'M', Place(x[k], xlo, xhi, LEFT, WIDTH - RIGHT),
            Place(y[k], ylo, yhi, HEIGHT - BOTTOM, TOP));
  fprintf(f, "'/>\n");
  for (PetscInt k = 0; k < n; k++)
    fprintf(f, "<circle cx='%.1f' cy='%.1f' r='4' fill='#1f77b4'/>\n", Place(x[k], xlo, xhi, LEFT, WIDTH - RIGHT),
            Place(y[k], ylo, yhi, HEIGHT - BOTTOM, TOP));
  fprintf(f, "<text x='%d' y='%d' text-anchor='middle'>", (LEFT + WIDTH - RIGHT) / 2, HEIGHT - 18);
  Text(f, xlabel);
  fprintf(f, "</text>\n<text transform='translate(18 %d) rotate(-90)' text-anchor='middle'>",
          (TOP + HEIGHT - BOTTOM) / 2);
  Text(f, ylabel);
  fprintf(f, "</text>\n</svg>\n");
  PetscCheck(!fclose(f), PETSC_COMM_SELF, PETSC_ERR_FILE_WRITE, "cannot write %s: %s", path, strerror(errno));
  PetscFunctionReturn(PETSC_SUCCESS);
}
