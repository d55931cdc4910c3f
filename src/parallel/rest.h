/* rest.h - what a run keeps of the rest of its bodies, and of what restarts have given. */
#ifndef MPM_REST_H
#define MPM_REST_H

#include "base/base.h"

/* Whether the bodies are at rest (step/rest.c). */
typedef struct {
  PetscBool on;         /* forces are compared in each step */
  PetscBool shown;      /* -history_rest */
  PetscBool aside;      /* -history_rest in statics, where it says nothing */
  PetscReal limit;      /* -time_rest; 0: a run does not end when the bodies are at rest */
  PetscReal hold;       /* -time_rest_hold, s; 0: twice the time that a wave needs along the grid */
  PetscReal unbalanced; /* largest force out of balance on a node over the largest force that acts, in the last step */
  PetscReal since;      /* s: since when both ratios are below the limit; -1: they are not */
  PetscBool reached;    /* they have been for long enough: the run ends */
} MPMRest;

/* What restarts that changed the scene have given: energy, J, and momentum, N s, which gravity that was another before would
   not have; gravity up to now, m/s^2; and the strain energy of the last checkpoint, J (restart/changes.c). */
typedef struct {
  PetscReal energy, impulse[3], gravity[3], strain;
} MPMChanges;

/* Of a run in stages (-stages): the one that it is in, from 1 on, of n; when it began, and when the last one ends, s, if none
   ends at rest before. 0 of them: it has none. */
typedef struct {
  PetscInt  now, n;
  PetscReal began, end;
} MPMStages;

#endif
