/* table.c - full names of options: names of the vocabulary with names of the scene in them. */
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
