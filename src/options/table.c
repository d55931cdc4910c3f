/* table.c - full names of options: names of the vocabulary with names of the scene in them. */
#include <strings.h>
#include "options/reader.h"

/* Writes the name of a row to full, with `name` in the place of <.>. */
void MPMOptionsFullName(const char row[], const char name[], char full[MPM_FULL_LEN])
{
  const char *open = strchr(row, '<');

  if (!open || !name)
    (void)snprintf(full, MPM_FULL_LEN, "%s", row);
  else
    (void)snprintf(full, MPM_FULL_LEN, "%.*s%.*s%s", (int)(open - row), row, MPM_NAME_LEN - 1, name, open + 3);
}

/* Described in options.h. */
const MPMOptionRow *MPMOptionsRow(MPMOptions o, const char name[])
{
  for (size_t r = 0; r < o->table->n; r++) {
    const char *row = o->table->row[r].name, *open = row ? strchr(row, '<') : NULL,
               *close = open ? strchr(open, '>') : NULL;
    const size_t tail = close ? strlen(close + 1) : 0, n = strlen(name);

    if (!row) continue;
    if (!open && !strcasecmp(row, name)) return &o->table->row[r];
    if (open && !strncasecmp(row, name, (size_t)(open - row)) && n > tail && !strcasecmp(name + n - tail, close + 1))
      return &o->table->row[r];
  }
  return NULL;
}
