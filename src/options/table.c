/* table.c - names of the vocabulary with those of the scene put in. */
#include "options/reader.h"

/* Puts a name in the place of <.> in a row's. */
void MPMOptionsFullName(const char row[], const char name[], char full[MPM_FULL_LEN])
{
  const char *open = strchr(row, '<');

  if (!open || !name)
    (void)snprintf(full, MPM_FULL_LEN, "%s", row);
  else
    (void)snprintf(full, MPM_FULL_LEN, "%.*s%.*s%s", (int)(open - row), row, MPM_NAME_LEN - 1, name, open + 3);
}
