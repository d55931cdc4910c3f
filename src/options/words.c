/* words.c - words of other programs: for options of this one, and for what it has not or calls otherwise (run/words.def). Nothing
   here may call PETSc, which may not have started. */
#include <ctype.h>
#include "options/reader.h"

PetscBool MPMOptionsAreAlike(const char a[], size_t na, const char b[], size_t nb)
{
  const char *const enda = a + na, *const endb = b + nb;

  for (;; a++, b++) {
    while (a < enda && strchr("-_* ", *a)) a++;
    while (b < endb && strchr("-_* ", *b)) b++;
    if (a == enda || b == endb) return a == enda && b == endb;
    if (tolower((unsigned char)*a) != tolower((unsigned char)*b)) return PETSC_FALSE;
  }
}

PetscBool MPMOptionsHasWord(const char words[], const char word[], size_t n)
{
  for (const char *w = words + strspn(words, " "); *w; w += strspn(w, " ")) {
    const size_t len = strcspn(w, " ");

    if (MPMOptionsAreAlike(w, len, word, n)) return PETSC_TRUE;
    w += len;
  }
  return PETSC_FALSE;
}

const char *MPMOptionsForeignValue(const MPMVocabulary *table, const char row[], const char value[])
{
  const int all = strchr(row, '<') ? 2 : 1; /* those of models, shapes, types are also words of names */

  for (int of = 0; of < all; of++) /* first the words of this option */
    for (size_t k = 0; k < table->nforeign; k++)
      if (!strcmp(table->foreign[k].row, of ? "" : row) &&
          MPMOptionsHasWord(table->foreign[k].value, value, strlen(value)))
        return table->foreign[k].text;
  return NULL;
}

const char *MPMOptionsForeign(const MPMVocabulary *table, const char given[])
{
  const char *text = NULL;
  size_t      most = 0;

  for (size_t k = 0; k < table->nforeign; k++)
    for (const char *at = given; !table->foreign[k].row[0] && *at; at += strcspn(at, "_"), at += strspn(at, "_"))
      for (size_t n = strcspn(at, "_"); n; n += at[n] ? 1 + strcspn(at + n + 1, "_") : 0) { /* one word, two, ... */
        if (n > most && MPMOptionsHasWord(table->foreign[k].value, at, n)) {
          text = table->foreign[k].text;
          most = n;
        }
        if (!at[n]) break;
      }
  return text;
}

/* Prints what a word of the table is, with the words [n], or all of them. */
static void PrintWord(const MPMOptionValue *one, const char word[])
{
  printf("  %s%s%s: %s\n", word, one->row[0] ? ", of -" : "", one->row, one->text);
}

size_t MPMOptionsPrintWords(const MPMVocabulary *table, const char word[], PetscBool titled, PetscBool print)
{
  size_t found = 0;

  for (size_t k = 0; k < table->nforeign; k++) {
    if (word && !MPMOptionsHasWord(table->foreign[k].value, word, strlen(word))) continue;
    if (print && !found) printf("%swords of other programs\n", titled ? "\n" : "");
    if (print) PrintWord(&table->foreign[k], word ? word : table->foreign[k].value);
    found++;
  }
  return found;
}

/* Described in reader.h. */
int MPMOptionsDistance(const char a[], const char b[])
{
  int       d[3][MPM_FULL_LEN + 1];
  const int na = (int)strlen(a), nb = (int)strlen(b);

  if (na > MPM_FULL_LEN || nb > MPM_FULL_LEN) return 1000;
  for (int j = 0; j <= nb; j++) d[0][j] = j;
  for (int i = 1; i <= na; i++) {
    int *now = d[i % 3], *last = d[(i + 2) % 3], *before = d[(i + 1) % 3];

    now[0] = i;
    for (int j = 1; j <= nb; j++) {
      const int same = tolower(a[i - 1]) == tolower(b[j - 1]);

      now[j] = PetscMin(PetscMin(last[j] + 1, now[j - 1] + 1), last[j - 1] + !same);
      if (i > 1 && j > 1 && tolower(a[i - 1]) == tolower(b[j - 2]) && tolower(a[i - 2]) == tolower(b[j - 1]))
        now[j] = PetscMin(now[j], before[j - 2] + 1);
    }
  }
  return d[na % 3][nb];
}
