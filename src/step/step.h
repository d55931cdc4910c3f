/* step.h - a step of the method, and how long the next one is. */
#ifndef MPM_STEP_H
#define MPM_STEP_H

#include "kernels/round.h"
#include "scene/scene.h"
#include "step/scheme.h"

/* Makes a step from core->t over params.dt and params.kick, and ends it. After the first function core->status holds
   what the step found, and particles and order are still where they were, so that the step can be undone
   (MPMParticlesPutBack). The second one removes, migrates and sorts particles; it may not be called where the state is
   bad. Collective on the exchange. */
PetscErrorCode MPMStepMake(MPMCore *, const MPMScene *);
PetscErrorCode MPMStepSettle(MPMCore *);

/* Sets mass and velocity of the nodes for the present state, as output shows them. It changes no particle, and is not
   timed as a part of a step. Collective on the exchange. */
PetscErrorCode MPMStepNodes(MPMCore *);

/* Means at the nodes of any numbers that the particles here have, weighted by mass. Begin returns r [n][dim], scratch
   of the particles; each call of MPMStepRecover takes from it what the particles read of its means; End gives the
   memory back. They change no particle, and are not timed as a part of a step. Collective on the exchange. */
PetscErrorCode MPMStepRecoverBegin(MPMCore *, PetscReal **r);
PetscErrorCode MPMStepRecover(MPMCore *);
PetscErrorCode MPMStepRecoverEnd(MPMCore *);

/* Sets status.v2 and status.c2 to the largest squared speeds of a particle and of a wave in the present state, m^2/s^2.
   A step does so too; this is for the state before the first step. Collective on the exchange. */
PetscErrorCode MPMStepBound(MPMCore *);

/* The energy that steps bring and take (energy.c), in core->energy. MPMEnergyStep notes the particles as a step begins,
   after the forces are set, and adds what it did to them before they are settled; MPMEnergyNodes adds what phase k
   of the program, one of nodes, did, where that counts, and MPMEnergyVolumes, times `sign`, what relaxing fluids store. MPMEnergyLost returns
   whether a law stores only a part of the work of its stress. MPMEnergyHeat asks for the dissipation of n bodies with
   ids [2 k] .. [2 k + 1] - 1, and MPMEnergyFollows returns whether anything is to be summed. Not collective. */
PetscErrorCode       MPMEnergyStep(MPMCore *, PetscBool begins);
PetscErrorCode       MPMEnergyNodes(MPMCore *, PetscInt k);
PetscErrorCode       MPMEnergyVolumes(MPMCore *, PetscInt sign);
PetscErrorCode       MPMEnergyDestroy(MPMEnergy *);
PetscInt             MPMEnergyBytes(const MPMCore *); /* memory that it needs for a particle */
PetscBool            MPMEnergyLost(const MPMMaterial *);
PetscErrorCode       MPMEnergyHeat(MPMEnergy *, PetscInt n);
PetscErrorCode       MPMEnergyHeatDestroy(MPMEnergy *);
MPM_INLINE PetscBool MPMEnergyFollows(const MPMCore *core)
{
  return core->energy.loads || core->energy.on || core->energy.nheat;
}

/* Returns the work of the walls of a node, number i on x, along axis d, by its mass and kick: what the acceleration a
   does along u, less what the force and gravity do along s, m^2/s^3 (energy.c). */
MPM_INLINE PetscReal MPMEnergyWall(const MPMCore *core, const MPMNode *n, PetscInt i, PetscInt d, PetscReal a,
                                   PetscReal u, PetscReal s)
{
  const PetscReal other = n->f[d] / MPMNodeMass(&core->grid, n, i, d) + core->params.gravity[d];

  return (a - other) * s + a * (u - s);
}

/* What walls give the matter (reactions.c), in core->reactions, if the history asks for some faces (bits). SetUp
   follows the set-up of the step's program; MPMReactionsPhase adds what phase k of the program did, and is called
   before it too. Not collective. */
PetscErrorCode MPMReactionsCreate(MPMCore *, PetscInt faces);
PetscErrorCode MPMReactionsDestroy(MPMCore *);
void           MPMReactionsSetUp(MPMCore *);
PetscErrorCode MPMReactionsPhase(MPMCore *, PetscInt k, PetscBool begins);

/* The gaps between matter and walls that only push (gaps.c), in core->gaps, if there are such walls. Create lets their
   faces show them to the nodes; MPMGapsUpdate finds them for the present positions and the step core->params.dt.
   Collective on the exchange, but for the first two. */
PetscErrorCode MPMGapsCreate(MPMCore *, MPMWalls *);
PetscErrorCode MPMGapsDestroy(MPMCore *);
PetscErrorCode MPMGapsUpdate(MPMCore *);

/* Pistons (pistons.c), in core->pistons, if there are any. Create follows MPMGapsCreate. MPMPistonsUpdate finds the
   weights of nodes at the present positions, and MPMPistonsAfter follows a phase of nodes; both are collective on
   exchange.data. */
PetscErrorCode MPMPistonsCreate(MPMCore *);
PetscErrorCode MPMPistonsDestroy(MPMCore *);
PetscErrorCode MPMPistonsUpdate(MPMCore *);
PetscErrorCode MPMPistonsAfter(MPMCore *, const MPMPhase *);

/* Contact (contact_find.c, contact.c), in core->contacts, if there is any: where bodies may meet at the present
   positions in the step core->params.dt, and what they do to the nodes after a phase of these. MPMContactsSettle is for
   settled particles whose cells are new: it finds which copies of the nodes are near each other, gives them their
   places, and settles the particles once more where these change. Follow comes before a step is settled: it
   notes how far bodies may have come, and if a particle has left the nodes that its copy has, settles the step itself with
   all nodes for all copies. All are collective on exchange.data. */
PetscErrorCode MPMContactsDestroy(MPMCore *);
PetscErrorCode MPMContactsFollow(MPMCore *, PetscBool *settled);
PetscErrorCode MPMContactsSettle(MPMCore *);
PetscErrorCode MPMContactsFind(MPMCore *);
PetscErrorCode MPMContactsAfter(MPMCore *, const MPMPhase *);

/* Set dv [dim], m/s, to what contact gave node ijk [3] of the grid in the last phase, for what counts the impulses of
   walls (reactions.c), or e [3] to its direction; returns whether it gave anything. Not collective. */
void      MPMContactsGave(const MPMCore *, const PetscInt ijk[], PetscReal dv[]);
PetscBool MPMContactsPush(const MPMCore *, const PetscInt ijk[], PetscReal e[]);

/* Rigid bodies that are free (rigid.c). MPMRigidsBegin gives them gravity's impulse, and finds where they stand on
   walls at the present positions; MPMRigidsStand lets walls act once, and returns the largest change of a velocity,
   m/s; MPMRigidsMove moves all rigid bodies at the end of a step, and adds up the work on free ones; MPMRigidsCheck
   says in core->stop if two of them meet, or if a free one has left the grid or come across a periodic face. Not
   collective. */
PetscErrorCode MPMRigidsDestroy(MPMCore *);
PetscErrorCode MPMRigidsBegin(MPMCore *);
PetscReal      MPMRigidsStand(MPMCore *);
void           MPMRigidsMove(MPMCore *);
void           MPMRigidsCheck(MPMCore *);

/* What acts on surfaces after a phase of nodes: contact, then pistons (contact.c). Collective on exchange.data. */
PetscErrorCode MPMSurfacesAfter(MPMCore *, const MPMPhase *);

/* The total frame (total.c). MPMTotalStart finds the masses of the nodes and, unless the run goes on from a checkpoint,
   their velocities, and is collective on the exchange. MPMTotalPass notes how far walls move in a step, core->passed,
   and MPMTotalScale multiplies the velocities of the nodes by `keep`; neither is collective. */
PetscErrorCode MPMTotalStart(MPMCore *, PetscBool restarted);
void           MPMTotalScale(MPMCore *, PetscReal keep);

/* Returns whether a phase moves the nodes in the total frame; and copies their state before it to core->before, for
   what is summed afterwards. Not collective. */
PetscBool      MPMTotalKicks(const MPMPhase *);
PetscErrorCode MPMTotalKeep(MPMCore *);

/* Adds sign dt/4 g . sum m v to core->half, J: before the first step with sign 1, after it with -1. By that the work of
   gravity in the kick of this step, half as long as dt, differs from what MPMShownWork would take it for. Collective on
   exchange.data. */
PetscErrorCode MPMTotalHalf(MPMCore *, PetscReal sign);
void           MPMTotalPass(MPMCore *);

/* Damping of all motion (damping.c): read its options; before the phases of a step, and after them if the state is
   good, which is collective on the exchange. MPMDampingIsOn returns whether there is any. */
PetscErrorCode MPMDampingSetFromOptions(MPMCore *, MPMOptions);
PetscErrorCode MPMDampingBegin(MPMCore *);
PetscErrorCode MPMDampingEnd(MPMCore *);
PetscBool      MPMDampingIsOn(const MPMCore *);

/* Whether the bodies are at rest (rest.c): read the options; compare the forces on the nodes after the phases of a
   step, whose sums and motion they still have; and note, with the kinetic energy over the strain energy of the present
   state, since when they are at rest. MPMRestHold returns how long they have to be, s. The second is collective on the
   exchange, the others are not. */
PetscErrorCode MPMRestSetFromOptions(MPMCore *, MPMOptions);
PetscErrorCode MPMRestStep(MPMCore *);
void           MPMRestNote(MPMCore *, PetscReal share);
PetscReal      MPMRestHold(const MPMCore *);

/* What determines the length of steps. None of the functions is collective: core->status is the same on all
   processes. */
typedef struct {
  PetscReal end, fixed, cfl; /* s, s, 1; fixed 0: dt = cfl h/(c + |v|) */
  PetscInt  max_steps;
} MPMTime;

PetscReal MPMTimeStep(const MPMCore *, const MPMTime *); /* dt of the next step, s */
PetscReal MPMRigidStep(const MPMCore *, PetscReal dt,
                       PetscInt *which);             /* dt, or less: a rigid body comes as far as it may;
                                                                           which: that body, or -1 */
PetscReal MPMKick(PetscReal was, PetscReal dt);      /* time over which velocities change in it, s; was: dt before */
PetscReal MPMCourant(const MPMCore *, PetscReal dt); /* dt (c + |v|)/h of the present state */
void      MPMDamp(MPMCore *, const MPMMethod *);     /* sets the share of FLIP, params.flip, of the step params.dt */
PetscReal MPMWaveCourant(const MPMCore *, PetscReal dt); /* dt c/h of the present state */
PetscReal MPMViscousStep(const MPMCore *);               /* bound of dt by viscosity, s; infinite without viscosity */

/* The relaxation of volumes (volume.c). SetUp sets core->volumes and which materials follow; kinds have to be known.
   MPMVolumesRelax returns whether anything relaxes. They are not collective. MPMVolumesStep relaxes, if the time has
   come, before the phases of a step; `last` is the status of the step before. Collective on the exchange.
   MPMVolumesAfter follows its phase of nodes where there are rigid bodies, and is not collective. */
void           MPMVolumesSetUp(MPMCore *, MPMMaterial *materials, const MPMTime *);
PetscBool      MPMVolumesRelax(const MPMCore *);
PetscErrorCode MPMVolumesStep(MPMCore *, const MPMStatus *last);
PetscErrorCode MPMVolumesAfter(MPMCore *, const MPMPhase *);

#endif
